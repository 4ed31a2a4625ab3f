"""Fixtures of the tests in a real browser (`conftest` hands them out), and what those tests do with a page."""

from __future__ import annotations

import json
import re
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest

import tests.testbench.report.samples as example
from compensation.cli import main as compensation
from gcode.cli import main as gcode
from testbench.cli import main as run_testbench
from tests.testbench.studio.served import CHROMIUM, Served, blame_the_server, served

SHOTS = Path(__file__).parents[4] / "artifacts" / "studio"
PATIENCE_MS = 200_000  # of every wait, of a fit too: a machine may be busy
IN_CHROMIUM = [
    pytest.mark.browser,
    pytest.mark.slow,
    pytest.mark.skipif(not CHROMIUM.exists(), reason="needs Debian's chromium"),
]


@pytest.fixture(scope="module")
def browser():
    """Debian's chromium, headless."""
    playwright = pytest.importorskip("playwright.sync_api")
    playwright.expect.set_options(timeout=PATIENCE_MS)
    with playwright.sync_playwright() as play:
        chromium = play.chromium.launch(executable_path=str(CHROMIUM), args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture(autouse=True)
def server_without_a_traceback() -> Iterator[None]:
    """A handler that raises leaves the page as it was, and speaks on the server alone: the test that did it fails."""
    yield
    blame_the_server()


@pytest.fixture
def running(tmp_path: Path) -> Iterator[Served]:
    """A studio as users start it, over an empty workspace."""
    with served(tmp_path / "ws") as studio:
        yield studio


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """One studio for all tests of a module, each of which makes campaigns of its own."""
    with served(tmp_path_factory.mktemp("shared") / "ws") as studio:
        yield studio


@pytest.fixture
def page(browser):
    """A tab at 1280 x 800 that fails on any script error and on anything fetched from elsewhere."""
    wrong: list[str] = []
    with screen(browser, 1280, 800) as tab:
        tab.on("pageerror", lambda error: wrong.append(str(error)))
        tab.on("console", lambda message: wrong.append(message.text) if message.type == "error" else None)
        tab.on("request", lambda request: _note_foreign(request.url, wrong))
        yield tab
    assert not wrong, "\n".join(wrong)


@contextmanager
def screen(browser, width: int, height: int, **options):
    """A tab in a browser of its own, of so many pixels."""
    context = browser.new_context(viewport={"width": width, "height": height}, **options)
    context.set_default_timeout(PATIENCE_MS)
    tab = context.new_page()
    tab.goto = partial(_gone_to, tab, tab.goto)
    try:
        yield tab
    finally:
        context.close()


def _gone_to(tab, go: Callable, url: str) -> None:
    """Open an address and wait until its page talks with the server: it reloads itself, and loses all that was filled
    in, where that takes long."""
    go(url)
    tab.wait_for_function("() => !document.getElementById('app') || window.did_handshake")


TABLET = {"width": 820, "height": 1180, "has_touch": True}
PHONE = {"width": 390, "height": 844, "has_touch": True, "is_mobile": True}


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace in which every step of one campaign has been made."""
    root = tmp_path_factory.mktemp("finished")
    program, knit, results = root / "programs" / "short", root / "knit", root / "results" / "knit"
    motion = ["--preset", "paper-1", "--seed", "7", "--gauge-length-mm", "25", "--duration-s", "240"]
    assert gcode(["generate", *motion, "-o", str(program)]) == 0
    sensor = ["--sensor", "pes", "--program", str(program / "program.tap"), "--seed", "1"]
    assert run_testbench(["run", *sensor, "-o", str(knit)]) == 0
    results.mkdir(parents=True)
    model, compensator = results / "model.json", results / "force.compensator.json"
    assert run_testbench(["fit", str(knit), "-o", str(model)]) == 0
    history = json.loads(model.read_text())["history"]
    (results / "diagnosis.json").write_text(json.dumps(example.diagnosis() | {"history": history}))
    training = ["train", str(knit), "--target", "force", "--hidden", "4,2,2", "-o", str(compensator)]
    assert compensation(training) == 0
    assert compensation(["score", str(compensator), str(knit), "-o", str(results / "force.score.json")]) == 0
    return root


@pytest.fixture(scope="module")
def standing(finished: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A studio over a copy of that workspace, for tests that only look: one for all of a module."""
    root = tmp_path_factory.mktemp("standing") / "ws"
    shutil.copytree(finished, root)
    with served(root) as studio:
        yield studio


@pytest.fixture
def full(running: Served, finished: Path) -> Served:
    """A studio over a copy of that workspace."""
    shutil.copytree(finished, running.root, dirs_exist_ok=True)
    return running


def opened(running, page, path: Path) -> None:
    """The import page with a file read."""
    page.goto(f"{running.address}/import")
    page.get_by_label("File on this machine").fill(str(path))
    page.get_by_role("button", name="Read the file").click()
    page.get_by_text("Found: ").wait_for()


def choose(page, label: str, option: str) -> None:
    """Take an option of a select."""
    page.get_by_role("combobox", name=label, exact=True).click()
    page.get_by_role("option", name=option, exact=True).click()


def _note_foreign(url: str, wrong: list[str]) -> None:
    if not re.match(r"(https?|wss?)://127\.0\.0\.1[:/]|data:|blob:|about:|file:", url):
        wrong.append(f"fetched from outside: {url}")


def until(page, holds: Callable[[], bool], patience_s: float = 200.0) -> None:
    """Wait until something holds that no page shows; the page goes on meanwhile."""
    start_s = time.monotonic()
    while not holds():
        assert time.monotonic() - start_s < patience_s, f"still not so after {patience_s:g} s"
        page.wait_for_timeout(100)


def samples(page, least: int) -> None:
    """Wait until the live page counts so many samples."""
    counted = "Number(/([0-9]+) Samples/.exec(document.body.innerText)?.[1] ?? 0)"
    page.wait_for_function(f"least => {counted} >= least", arg=least)


def shot(page, name: str) -> None:
    """A screenshot among CI's artefacts."""
    SHOTS.mkdir(parents=True, exist_ok=True)
    page.wait_for_timeout(700)  # for the plots to settle; only the picture waits
    page.screenshot(path=SHOTS / f"{name}.png")
