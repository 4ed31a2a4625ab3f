"""The import's messages in the words of its page: where the command line says an option, the page says its field."""

from __future__ import annotations

import re
from collections.abc import Sequence

TITLES = {
    "time": "Time",
    "displacement": "Displacement",
    "strain": "Strain",
    "force": "Force",
    "resistance": "Resistance",
    "conductance": "Conductance",
    "relative": "R/R0",
    "relative_change": "(R-R0)/R0",
    "temperature": "Temperature",
}
R0 = "Resistance at rest R0 / Ω"
FIELDS = {
    "--gauge-length-mm": "Gauge length / mm",
    "--header-row": "Header row",
    "--units-row": "Units row",
    "--separator": "Separator",
    "--decimal": "Decimal sign",
    "--thousands": "Thousands",
    "--encoding": "Encoding",
    "--sheet": "Sheet",
    "--rate-hz": "Sampling rate / Hz",
    "--rest-ohm": R0,
    "--r0-ohm": R0,
    "--drop-bad": "Leave out rows that cannot be used",
    "--sort": "Put rows in the order of time",
    "--repeat": "Only repeat",
    "--negate": "Turn the sign",
    "--zero": "Count from the first sample",
    "--time-of": "Own times",
    "--output": "Campaign name",
    "--overwrite": "Campaign name",
}
SIGNS = {",": "comma", ".": "point"}
_AT = r"(?: (?:displacement|force|strain|resistance)\b)"
_ROLES = {"relative-resistance": "relative"} | {role.replace("_", "-"): role for role in TITLES}


def left_out_in_words(left_out: Sequence[Sequence[str]], kinds: str) -> str:
    """Why the uploader did not take files, each given as its reason and its name; `kinds` is what it takes."""
    told = {
        "accept": f"no file of a kind that can be read ({kinds.replace(',', ', ')})",
        "max-file-size": "too large for a browser; say where it is under “File on this machine”",
    }
    otherwise = "left out, for one file is imported at a time"
    return "; ".join(f"{name}: {told.get(reason, otherwise)}" for reason, name in left_out)


def page_words(text: str) -> str:
    """A message of the command line as the page says it.

    ``say --force-unit`` becomes ``choose “Unit of force”``, ``--drop-bad leaves`` becomes ``“Leave out rows that
    cannot be used” leaves``.
    """
    text = re.sub(r"`(\w+)`", lambda name: f"--{name[1].replace('_', '-')}", text)  # a field of `testbench.Wish`
    text = re.sub(r"\b(?:say|add|name) (?=--)", "choose ", text)
    text = re.sub(r"(?<=or )(?=--)", "choose ", text)
    text = re.sub(r"(--(?:decimal|thousands)) ([,.])", lambda it: f"{it[1]} {SIGNS[it[2]]}", text)
    text = re.sub(r"(--[a-z-]+(?<!-row)) (?:[A-Z]+\b|none\b|\d+)", r"\1", text)
    for name in sorted(_ROLES, key=len, reverse=True):
        text = re.sub(rf"--{name}-unit\b", f"“Unit of {_spoken(name)}”", text)
        text = re.sub(rf"--{name}(?![\w-])", f"“Column of {_spoken(name)}”", text)
    for flag in sorted(FIELDS, key=len, reverse=True):
        text = re.sub(rf"{flag}(?![\w-])({_AT}*)", f"“{FIELDS[flag]}”\\1", text)
    return re.sub(rf"”({_AT}+)", lambda found: f"” at{found[1]}", text)


def _spoken(name: str) -> str:
    role = _ROLES[name]
    return TITLES[role] if role.startswith("relative") else role


def in_a_sentence(title: str) -> str:
    """A title as it stands within a sentence: symbols stay as they are."""
    return title if "R0" in title else title.lower()
