"""Every command line that a page or a help text shows is one that the command line takes."""

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


SUB_COMMANDS = [
    (program, sub) for program in ("gcode", "testbench", "compensation")
    for sub in importlib.import_module(f"{program}.cli").COMMANDS
]  # fmt: skip


def commands() -> list[tuple[str, str]]:
    """Page or command, and command line, continued lines joined."""
    texts = [(page.name, page.read_text(encoding="utf-8")) for page in PAGES]
    for program, sub in SUB_COMMANDS:
        example = importlib.import_module(f"{program}.commands.{sub}").EXAMPLE
        texts.append((f"{program} {sub} --help", re.sub("^ *", "    ", example, flags=re.MULTILINE)))
    found = []
    for name, text in texts:
        text = re.sub(r"\s*\\\n\s*", " ", text)
        # What stands to the right of a wide gap says what the line does.
        found += [(name, re.split(r"\s{2,}| &$", line)[0]) for line in SHOWN.findall(text)]
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


@pytest.mark.parametrize(("program", "sub"), SUB_COMMANDS)
def test_the_usage_of_a_command_closes_each_bracket(program, sub, monkeypatch):
    """Where two groups that exclude each other meet, argparse may drop "] [" and leave two blanks."""
    monkeypatch.setenv("COLUMNS", "200")
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.suppress(SystemExit):
        build_parser(program, "", f"{program}.commands", [sub]).parse_args([sub, "--help"])
    assert not re.search(r"\S  -", said.getvalue().partition("\n\n")[0])
