"""The import's messages in the words of Python: an option of the command line is a field of `testbench.Wish`."""

from __future__ import annotations

import re
from functools import partial

from testbench.importing.choice import FLAGS
from testbench.importing.vocabulary.roles import ROLES

SWITCHES = ("drop_bad", "sort")
NUMBERS = {"gauge-length-mm": "gauge_length_mm", "rate-hz": "rate_hz", "rest-ohm": "r0_ohm", "repeat": "repeat"}
HINTS = ("separator", "decimal", "thousands", "encoding", "sheet", "header_row", "units_row")
_OPTION = r"(?<![\w./\\-])--"  # as a word of its own: a file may be called day--force.csv
_ROLE = {flag.removeprefix("--"): role for role, flag in FLAGS.items()}
_A_ROLE = rf"({'|'.join(ROLES)})\b"
_GIVEN = r"(?: ([A-Z]\w*\b|none\b|\d+|[^\w\s](?=[ ;)]|$)))?"  # what stands behind an option as its value
_UNIT = r"(?: (%|date\b|[A-Za-zµ]{1,4}\b(?=[;,)]|$)))?"


def in_python(text: str) -> str:
    """A message of the command line as a person in Python acts on it.

    ``say --force-unit (N, kN)`` becomes ``say units={'force': ...} (N, kN)``, ``--drop-bad leaves`` becomes
    ``drop_bad=True leaves``; at its end stands whose fields they are.
    """
    told = re.sub(rf"{_OPTION}time-of (\w+)=(\w*)", partial(_by_role, "time_of"), text)
    told = re.sub(rf"{_OPTION}time-of\b", "time_of", told)
    told = re.sub(rf"{_OPTION}zero {_A_ROLE}=", lambda it: f"zero[{it[1]!r}]", told)
    told = re.sub(rf"{_OPTION}zero {_A_ROLE}", lambda it: f"zero={{{it[1]!r}: None}}", told)
    told = re.sub(rf"{_OPTION}negate {_A_ROLE}", lambda it: f"negate={{{it[1]!r}}}", told)
    told = re.sub(rf"{_OPTION}(zero|negate)\b", r"\1", told)
    for name in SWITCHES:
        told = re.sub(rf"{_OPTION}{name.replace('_', '-')}(?![\w-])", f"{name}=True", told)
    for name in HINTS:
        told = re.sub(rf"{_OPTION}{name.replace('_', '-')}(?![\w-]){_GIVEN}", partial(_hint, name), told)
    for name, field in NUMBERS.items():
        told = re.sub(rf"{_OPTION}{name}(?![\w-])(?: ([A-Z]\w*\b))?", partial(_number, field), told)
    told = re.sub(rf"{_OPTION}relative-unit{_UNIT}", partial(_by_option, "units", "relative"), told)
    for name in sorted(_ROLE, key=len, reverse=True):
        role = _ROLE[name]
        told = re.sub(rf"{_OPTION}{name}-unit{_UNIT}", partial(_by_option, "units", role), told)
        told = re.sub(rf"{_OPTION}{name}(?![\w-]){_GIVEN}", partial(_by_option, "columns", role), told)
    return text if told == text else f"{told} (testbench.Wish has these fields)"


def _by_role(field: str, found: re.Match[str]) -> str:
    return _entry(field, found[1], found[2])


def _by_option(field: str, role: str, found: re.Match[str]) -> str:
    return _entry(field, role, found[1])


def _entry(field: str, role: str, value: str | None) -> str:
    """One entry of a mapping of the wish, ``columns={'force': '3'}``; dots where the person has to fill in."""
    said = repr(value) if value and value != "COL" else "..."
    return f"{field}={{{role!r}: {said}}}"


def _hint(name: str, found: re.Match[str]) -> str:
    value = found[1] or "..."
    if value.isupper():  # NAME, N: the person knows which
        value = "..."
    return f"hints=Hints({name}={value if value == '...' or value.isdigit() else repr(value)})"


def _number(field: str, found: re.Match[str]) -> str:
    return f"{field}=..." if found[1] else field
