"""Every command line that a page shows is one that the command line takes."""

from __future__ import annotations

import contextlib
import importlib
import io
import re
import shlex
from pathlib import Path

import pytest

from gcode.support.console import build_parser

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
SHOWN = re.compile(
    r"^(?: {4,}(?:\$ )?|\$ )(?:\.venv/bin/)?((?:gcode|testbench|compensation) [a-z]+\b[^\n]*)$", re.MULTILINE
)


def commands() -> list[tuple[str, str]]:
    """Page and command line, continued lines joined."""
    found = []
    for page in PAGES:
        text = re.sub(r"\s*\\\n\s*", " ", page.read_text(encoding="utf-8"))
        # What stands to the right of a wide gap says what the line does.
        found += [(page.name, re.split(r"\s{2,}| &$", line)[0]) for line in SHOWN.findall(text)]
    return found


@pytest.mark.parametrize(("page", "line"), commands())
def test_a_command_line_of_a_page_is_understood(page, line):
    program, sub, *words = shlex.split(line, comments=True)
    known = importlib.import_module(f"{program}.cli").COMMANDS
    assert sub in known
    parser = build_parser(program, "", f"{program}.commands", [sub])
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.suppress(SystemExit):
        parser.parse_args([sub, *words])
    assert said.getvalue() == ""
