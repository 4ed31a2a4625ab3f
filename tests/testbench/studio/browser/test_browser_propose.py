"""A proposed law in a real browser: formula and picture are there, it fits a phone, and a click puts it to use."""

from __future__ import annotations

import json

from playwright.sync_api import expect

from testbench.studio.proposed_law import FOLDER
from tests.testbench.studio.browser.browsing import IN_CHROMIUM, PHONE, screen, shot
from tests.testbench.studio.browser.seeing import nameless, unreadable
from tests.testbench.studio.proposals import write_proposal
from tests.testbench.studio.served import Served

pytestmark = IN_CHROMIUM

ONE_PIXEL = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108060000001f15c4890000000d49444154789c636060606000000005"
    "0001a5f645400000000049454e44ae426082"
)


def proposed(full: Served) -> None:
    results = full.root / "results" / "knit"
    write_proposal(results / FOLDER, results / "model.json")
    (results / FOLDER / "sleeve_law.png").write_bytes(ONE_PIXEL)


def test_a_law_is_proposed_from_the_verdict_and_added_by_a_click(full: Served, page) -> None:
    proposed(full)
    page.goto(f"{full.address}/missing?c=knit")
    page.get_by_role("button", name="Propose a law").click()
    page.wait_for_url("**/propose?c=knit")
    page.get_by_text("Proposed: the force rises with the memory of the strain.").wait_for()
    page.get_by_text("The effect file").wait_for()
    expect(page.locator(".typeset svg")).to_have_count(2)
    page.wait_for_function("() => document.querySelector('figure img')?.naturalWidth === 1")
    assert not unreadable(page) + nameless(page)
    shot(page, "propose")
    page.get_by_role("button", name="Add sleeve law").click()
    page.wait_for_url("**/ladder?c=knit")
    page.get_by_text("Through the history").wait_for()
    history = json.loads((full.root / "results" / "knit" / "model.json").read_text())["history"]
    assert [step["step"] for step in history] == ["baseline", "+ sleeve_law"]
    assert "sleeve_law" in (full.root / "effects.py").read_text()


def test_a_proposed_law_fits_a_phone(full: Served, browser) -> None:
    proposed(full)
    with screen(browser, **PHONE) as tab:
        tab.goto(f"{full.address}/propose?c=knit")
        tab.get_by_text("The effect file").wait_for()
        shot(tab, "phone-propose")
        assert tab.evaluate("document.documentElement.scrollWidth") <= 390
        assert not unreadable(tab) + nameless(tab)
