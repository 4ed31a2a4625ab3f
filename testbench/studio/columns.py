"""Guessing what the columns of somebody's CSV are, so that most imports need no choosing."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

# Words as they stand in exports of tensile testers and loggers; the first match wins.
WORDS = {
    "time": ("time", "zeit", "sec", "t_s", "t"),
    "displacement": ("displacement", "extension", "position", "travel", "weg", "crosshead", "x"),
    "strain": ("strain", "dehnung", "elongation"),
    "force": ("force", "load", "kraft", "newton", "f"),
    "resistance": ("resistance", "ohm", "widerstand", "r"),
}
UNITS = {
    "time": ("s", "ms", "us", "min", "h"),
    "displacement": ("mm", "um", "cm", "m", "in"),
    "strain": ("1", "%"),
    "force": ("N", "mN", "cN", "kN", "gf", "kgf", "lbf"),
    "resistance": ("ohm", "mohm", "kohm", "Mohm"),
}


def column_names(path: Path) -> list[str]:
    """Names in the header of a CSV, whatever separates them.

    Raises
    ------
    UserError
        If the file is empty or is not text.
    """
    from testbench.foreign import SEPARATORS, layout_of

    layouts = [layout_of(path, [], separator) for separator in SEPARATORS]
    return [name for name in max(layouts, key=lambda layout: len(layout.names)).names if name]


def guess(names: Sequence[str], what: str) -> str | None:
    """The column that is most likely `what`; None when no name says so."""
    for word in WORDS[what]:
        for name in names:
            plain = name.lower()
            if plain == word or (len(word) > 1 and word in plain):
                return name
    return None


def guess_unit(name: str | None, what: str) -> str:
    """The unit that a column's name ends in, else the usual one."""
    units = UNITS[what]
    if name:
        tail = (
            name.replace("(", " ").replace("[", " ").replace("_", " ").replace("/", " ").strip(" )]").split(" ")[-1]
        )
        for unit in units:
            if tail == unit or (tail.lower() == unit.lower() and unit.lower() not in ("mn", "mohm")):
                return unit
    return units[0]
