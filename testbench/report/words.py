"""What a diagnosis says, in sentences for somebody who knows textiles and not statistics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from testbench.discrepancy.words import percent
from testbench.report.ladder_figures import UNITS

MANY = math.log(1e6)  # log odds beyond this are "more than a million to one"


def verdict_in_words(diagnosis: Mapping[str, Any]) -> str:
    """One sentence, or two."""
    if diagnosis["verdict"] == "missing":
        return _missing(diagnosis)
    chances = diagnosis["probabilities"]
    if diagnosis["verdict"] == "nothing_missing":
        return f"Nothing is missing that these recordings could show ({percent(chances['nothing'])})."
    if diagnosis["found"]:
        left = percent(diagnosis["left_unexplained"])
        said = (
            f"What was found, {_found(diagnosis)}, leaves {left} of the error above the noise: something is missing"
        )
        return f"{said} that no effect of the catalogue explains.{_depends(diagnosis)}"
    sure = percent(chances["unknown"])
    return f"Something is missing that no effect of the catalogue explains ({sure}).{_depends(diagnosis)}"


def _depends(diagnosis: Mapping[str, Any]) -> str:
    most = [f"{entry['channel']} on {spoken(entry['coordinate'])}" for entry in diagnosis.get("depends_on", [])[:2]]
    return f" What is left depends most on this: {'; '.join(most)}." if most else ""


def _found(diagnosis: Mapping[str, Any]) -> str:
    return ", then ".join(f"{spoken(one['effect'])} ({percent(one['probability'])})" for one in diagnosis["found"])


def _missing(diagnosis: Mapping[str, Any]) -> str:
    first = diagnosis["found"][0]["effect"]
    tied = [
        f"{spoken(name)} ({percent(diagnosis['probabilities'][name])})"
        for name in diagnosis.get("tied", [])
        if name != first
    ]
    fall = error_fall(diagnosis["error_before"], diagnosis["error_after"])
    sentence = f"The model is missing {_found(diagnosis)}: {fall}."
    if tied:
        sentence += f" These recordings hardly tell {spoken(first)} from {' or '.join(tied)}."
    return sentence


def error_fall(before: Mapping[str, float], after: Mapping[str, float]) -> str:
    """How the held-out error changes, channel by channel."""
    shown = [channel for channel in before if channel in after]
    falls = [f"from {before[channel]:.3g} to {after[channel]:.3g} {UNITS[channel]}" for channel in shown]
    parts = [f"that of the {channel} {fall}" for channel, fall in zip(shown[1:], falls[1:], strict=True)]
    return ", ".join([f"the held-out error of the {shown[0]} goes {falls[0]}", *parts])


def base_in_words(diagnosis: Mapping[str, Any]) -> str:
    """What is wrong with the base laws themselves; empty when nothing is."""
    names = [spoken(name.removesuffix("_shape")) for name in diagnosis.get("base_misfits", [])]
    laws = " and ".join(diagnosis.get("other_laws", []))
    better = f"The law {laws} suits this sensor better." if laws else ""
    if not names:
        return better
    if len(names) == 1:
        misfit = f"The base law itself misfits: the shape of its {names[0]} is not quite this sensor's."
    else:
        listed = f"{', '.join(names[:-1])} and {names[-1]}"
        misfit = f"The base laws themselves misfit: the shapes of {listed} are not quite this sensor's."
    return f"{misfit} {better}".strip()


def experiment_in_words(found: Mapping[str, Any]) -> str:
    """What the best motion of ``testbench experiment --json`` would settle, in a sentence or two."""
    best = found["options"][0]
    name = spoken(best["protocol"]).replace("-", " ")
    rivals = " from ".join(spoken(rival) for rival in found["rivals"])
    if best["grade"] == "cannot tell":
        return f"No motion within these limits tells {rivals}. Allow more strain, more speed or more time."
    odds = math.exp(min(best["log_odds"], MANY))
    against = "more than a million" if best["log_odds"] > MANY else f"{odds:.2g}"
    minutes = best["duration_s"] / 60
    grade = {"decisive": "decisively", "strong": "with strong evidence", "a hint": "with no more than a hint"}
    return (
        f"Run “{name}” for {minutes:.0f} min: the {best['channel']} will tell {rivals} {grade[best['grade']]}, "
        f"with expected odds of {against} to one."
    )


def clocks_in_words(delay_s: float, drift_ppm: float, duration_s: float) -> str:
    """How the plan's clock stands against the recorder's."""
    order = "after" if delay_s >= 0 else "before"
    start = "together with" if abs(delay_s) < 0.001 else f"{abs(delay_s):.3f} s {order}"
    gained_ms = 1e-3 * abs(drift_ppm) * duration_s
    if gained_ms < 1:
        return f"The plan began {start} the recording; their clocks run alike."
    pace = "gains" if drift_ppm > 0 else "loses"
    return f"The plan began {start} the recording; its clock {pace} {gained_ms:.0f} ms over the recording."


def spoken(name: str) -> str:
    """A catalogue name as words."""
    return str(name).replace("_", " ")
