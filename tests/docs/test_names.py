"""What pages and docstrings name is there: modules with what is in them, and the files of the map of the code."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("gcode", "testbench", "compensation")
TEXTS = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *(ROOT / "docs").rglob("*.md"),
    *(path for package in PACKAGES for path in (ROOT / package).rglob("*.py")),
]
NAME = re.compile(rf"`((?:{'|'.join(PACKAGES)})(?:\.[a-z_]\w*)+(?:\.\w+)?)`")
FILE = re.compile(r"`([\w/]+\.py)`")
FOLDERS = ("", *(f"{package}/" for package in PACKAGES), "testbench/fitting/", "testbench/diagnosis/")


def is_there(name: str) -> bool:
    """Whether a dotted name is a module, or something in one."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            if not hasattr(found, part):
                return part in getattr(found, "__annotations__", {}) or part in getattr(found, "model_fields", {})
            found = getattr(found, part)
        return True
    return False


def test_every_module_and_function_that_is_named_in_words_is_there() -> None:
    named = {name: path for path in TEXTS for name in NAME.findall(path.read_text(encoding="utf-8"))}
    assert len(named) > 30
    gone = {name: path.relative_to(ROOT) for name, path in named.items() if not is_there(name)}
    assert not gone


def test_a_name_that_is_gone_is_seen() -> None:
    assert is_there("testbench.knit.additive.ConductanceLaw")
    assert not is_there("testbench.knit.conductance.ConductanceLaw")


@pytest.mark.parametrize("path", FILE.findall((ROOT / "docs/architecture.md").read_text(encoding="utf-8")))
def test_every_file_on_the_map_is_there(path: str) -> None:
    assert any(ROOT.glob(f"*/{path}")) or any(ROOT.glob(f"*/*/{path}"))


def test_every_file_that_is_named_with_its_room_is_there() -> None:
    pages = [path for path in TEXTS if path.suffix == ".md"]
    told = {name: path.name for path in pages for name in FILE.findall(path.read_text(encoding="utf-8"))}
    named = {
        name: page for name, page in told.items() if "/" in name and name != "campaigns/effects.py"
    }  # a user's own
    assert len(named) > 30
    assert not {
        name: page for name, page in named.items() if not any((ROOT / one / name).is_file() for one in FOLDERS)
    }
