"""Fixtures of the tests in a real browser; a test module imports the ones it uses."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.testbench.studio.served import CHROMIUM, Served, served

SHOTS = Path(__file__).parents[3] / "artifacts" / "studio"
IN_CHROMIUM = [
    pytest.mark.browser,
    pytest.mark.slow,
    pytest.mark.skipif(not CHROMIUM.exists(), reason="needs Debian's chromium"),
]


@pytest.fixture(scope="module")
def browser():
    """Debian's chromium, headless."""
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as play:
        chromium = play.chromium.launch(executable_path=str(CHROMIUM), args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture
def running(tmp_path: Path) -> Iterator[Served]:
    """A studio as users start it, over an empty workspace."""
    with served(tmp_path / "ws") as studio:
        yield studio


@pytest.fixture
def page(browser):
    """A tab at 1280 x 800 that fails on any script error and on anything fetched from elsewhere."""
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    tab = context.new_page()
    tab.set_default_timeout(120_000)
    wrong: list[str] = []
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.on("console", lambda message: wrong.append(message.text) if message.type == "error" else None)
    tab.on("request", lambda request: _note_foreign(request.url, wrong))
    yield tab
    context.close()
    assert not wrong


def _note_foreign(url: str, wrong: list[str]) -> None:
    if not re.match(r"(https?|wss?)://127\.0\.0\.1[:/]|data:|blob:|about:|file:", url):
        wrong.append(f"fetched from outside: {url}")


def shot(page, name: str) -> None:
    """A screenshot among CI's artefacts."""
    SHOTS.mkdir(parents=True, exist_ok=True)
    page.wait_for_timeout(700)  # for the plots to settle; only the picture waits
    page.screenshot(path=SHOTS / f"{name}.png")
