"""What a diagnosis says, in sentences for somebody who knows textiles and not statistics."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from testbench.comparing.numbers import plain
from testbench.comparing.words import MANY, listed, percent_left, spoken
from testbench.diagnosis.verdict import verdict_clauses
from testbench.measurements.responses import UNIT_OF

PANEL_UNITS = {**UNIT_OF, "resistance": "kΩ"}  # of an axis or a table, by what it shows


def with_unit(value: float, channel: str, digits: int = 3) -> str:
    """``0.0741 N``: an error in the unit of its channel."""
    return f"{plain(value, digits)} {PANEL_UNITS[channel]}"


def sentence(text: str) -> str:
    """Words of a finding as a sentence of a page."""
    return f"{text[:1].upper()}{text[1:]}."


def duration_in_words(duration_s: float) -> str:
    """``23.0 min``; below a minute in seconds, from three hours on in hours."""
    if duration_s < 60:
        return f"{duration_s:.3g} s"
    return f"{duration_s / 60:.1f} min" if duration_s < 3 * 3600 else f"{duration_s / 3600:.1f} h"


def verdict_in_words(diagnosis: Mapping[str, Any]) -> str:
    """The verdict of a diagnosis in a few sentences, and what it did to the held-out error."""
    said = [*verdict_clauses(diagnosis)]
    if diagnosis["verdict"] == "missing":
        said.append(error_fall(diagnosis["error_before"], diagnosis["error_after"]))
    return " ".join(map(sentence, said))


def error_left(entry: Mapping[str, Any]) -> str:
    """``14 %``: what a refit with this effect leaves of the error on samples that no fit has seen.

    The one number of an effect, as `testbench diagnose` prints it; empty where it was not refitted.
    """
    gains = entry.get("held_out_gain")
    return f"{percent_left(gains[0]):.0f} %" if gains else ""


NOT_REFITTED = "not refitted: it would hardly lower the error"


def error_left_between(entry: Mapping[str, Any]) -> str:
    """``12 to 16 %``, the 95 % interval of `error_left`; empty where there is none."""
    gains = entry.get("held_out_gain")
    if not gains:
        return ""
    high, low = map(percent_left, gains[1:3])
    return f"{low:.0f} to {high:.0f} %"


SHAPE_FREEDOM = (
    "Shape freedom: the base laws may bend away from their formulas, so that a formula that does not quite fit this "
    "sensor is not taken for a missing effect."
)


def ladder_notes(steps: Iterable[str]) -> list[str]:
    """What is to be explained about the steps of a ladder."""
    free = any("shape" in step for step in steps)
    return [SHAPE_FREEDOM] if free else []


def error_fall(before: Mapping[str, float], after: Mapping[str, float]) -> str:
    """How the held-out error changes, channel by channel."""
    shown = [channel for channel in before if channel in after]
    falls = [f"from {plain(before[channel])} to {with_unit(after[channel], channel)}" for channel in shown]
    parts = [f"that of the {channel} {fall}" for channel, fall in zip(shown[1:], falls[1:], strict=True)]
    return ", ".join([f"the held-out error of the {shown[0]} goes {falls[0]}", *parts])


def base_in_words(diagnosis: Mapping[str, Any]) -> str:
    """What is wrong with the base laws themselves; empty when nothing is."""
    names = [spoken(name.removesuffix("_shape")) for name in diagnosis.get("base_misfits", [])]
    laws = [spoken(law) for law in diagnosis.get("other_laws", [])]
    one = "law {} suits" if len(laws) == 1 else "laws {} suit"
    better = f"The {one.format(listed(laws))} this sensor better." if laws else ""
    if not names:
        return better
    if len(names) == 1:
        misfit = f"The base law itself misfits: the shape of its {names[0]} is not quite this sensor's."
    else:
        misfit = f"The base laws themselves misfit: the shapes of {listed(names)} are not quite this sensor's."
    return f"{misfit} {better}".strip()


def experiment_in_words(found: Mapping[str, Any]) -> str:
    """What the best motion of ``testbench experiment --json`` would settle, in a sentence or two."""
    best = found["options"][0]
    name = spoken(best["protocol"]).replace("-", " ")
    rivals = " from ".join(spoken(rival) for rival in found["rivals"])
    if best["grade"] == "cannot tell":
        return f"No motion within these limits tells {rivals}. Allow more strain, more speed or more time."
    minutes = best["duration_s"] / 60
    grade = {"decisive": "decisively", "strong": "with strong evidence", "a hint": "with no more than a hint"}
    return (
        f"Run “{name}” for {minutes:.0f} min: the {best['channel']} will tell {rivals} {grade[best['grade']]}, "
        f"with expected odds of {odds_in_words(best['log_odds'])}."
    )


def odds_in_words(log_odds: float) -> str:
    """``12 to one``, of the natural logarithm of odds (a log evidence in nats)."""
    return f"{'more than a million' if log_odds > MANY else plain(math.exp(log_odds), 2)} to one"


def clocks_in_words(delay_s: float, drift_ppm: float, duration_s: float) -> str:
    """How the plan's clock stands against the recorder's."""
    order = "after" if delay_s >= 0 else "before"
    start = "together with" if abs(delay_s) < 0.001 else f"{abs(delay_s):.3f} s {order}"
    gained_ms = 1e-3 * abs(drift_ppm) * duration_s
    if gained_ms < 1:
        return f"the plan began {start} the recording; their clocks run alike"
    pace = "gains" if drift_ppm > 0 else "loses"
    clock = f"its clock {pace} {gained_ms:.0f} ms over the recording ({abs(drift_ppm):.0f} ppm)"
    return f"the plan began {start} the recording; {clock}"
