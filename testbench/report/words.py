"""What a diagnosis says, in sentences for somebody who knows textiles and not statistics."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from testbench.comparing.carried_over import fails_elsewhere
from testbench.comparing.numbers import plain
from testbench.comparing.words import MANY, listed, percent, percent_left, spoken, still_off
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
    """The verdict of a diagnosis in one or two sentences."""
    verdict, ranking = diagnosis["verdict"], diagnosis["ranking"]
    if verdict == "missing" and ranking:
        return _missing(diagnosis)
    if verdict == "unknown":
        return _unknown(diagnosis) + _depends(diagnosis)
    probability = probability_of(diagnosis, "nothing")
    said = f"Nothing is missing that these recordings could show{_bracketed(probability)}."
    if bend := diagnosis.get("bends_like"):
        said += f" But a law of the base is bent as {with_probability(diagnosis, bend)} would bend it."
    return said + _held_out(diagnosis)


def _held_out(diagnosis: Mapping[str, Any]) -> str:
    """What is said where the held-out error is not what the first words promise."""
    history = diagnosis.get("history")
    fails = fails_elsewhere(history, len(diagnosis["found"])) if history else ""
    but = fails or still_off(diagnosis["error_after"], diagnosis["noise_floor"])
    return f" But {but}." if but else ""


def _unknown(diagnosis: Mapping[str, Any]) -> str:
    """That no effect explains enough; of one that is more probable than that there is none, what it leaves."""
    probability, first = probability_of(diagnosis, "unknown"), next(iter(diagnosis["ranking"]), None)
    if first is None or (first.get("probability") or 0.0) <= (probability or 0.0):
        return f"Something is missing that no effect of the catalogue explains{_bracketed(probability)}."
    probable = with_probability(diagnosis, first["effect"])
    left = f"{100 * first['error_share_left']:.0f} % of the error above the noise"
    return f"No effect of the catalogue explains most of what is missing: {probable} is probable, but leaves {left}."


def _bracketed(probability: float | None) -> str:
    return "" if probability is None else f" ({percent(probability)})"


def _depends(diagnosis: Mapping[str, Any]) -> str:
    most = [
        f"{entry['channel']} on {spoken(entry['coordinate'])} ({percent(entry['gain'])} of it)"
        for entry in diagnosis.get("depends_on", [])[:2]
    ]
    return f" What is left depends most on this: {'; '.join(most)}." if most else ""


def _missing(diagnosis: Mapping[str, Any]) -> str:
    first = diagnosis["ranking"][0]
    found = diagnosis["found"]
    names = [with_probability(diagnosis, found[0]["effect"])]
    names += [f"{spoken(one['effect'])} ({percent(one['probability'])})" for one in found[1:]]
    tied = [with_probability(diagnosis, name) for name in diagnosis.get("tied", []) if name != found[0]["effect"]]
    left = error_left(first) if len(found) == 1 else ""
    sentence = f"The model is missing {', then '.join(names)}"
    mean = ", the mean of the channels," if len(diagnosis["error_before"]) > 1 else ""
    sentence += f": with it {left} of the held-out error{mean} is left." if left else "."
    sentence += f" In all, {error_fall(diagnosis['error_before'], diagnosis['error_after'])}."
    if tied:
        which = "it" if len(found) == 1 else spoken(found[0]["effect"])
        sentence += f" These recordings cannot tell {which} from {' or '.join(tied)}."
    return sentence + _held_out(diagnosis)


def with_probability(diagnosis: Mapping[str, Any], effect: str) -> str:
    """``stress relaxation (97 %)``; without the figure where the diagnosis has none."""
    probability = probability_of(diagnosis, effect)
    return spoken(effect) if probability is None else f"{spoken(effect)} ({percent(probability)})"


def probability_of(diagnosis: Mapping[str, Any], effect: str) -> float | None:
    """How probable it is that just this is missing (or ``nothing``, or ``unknown``); None in older diagnoses."""
    found = (diagnosis.get("probabilities") or {}).get(effect)
    if found is None:
        rows = (row for row in diagnosis.get("ranking", []) if row["effect"] == effect)
        found = next((row["probability"] for row in rows if row.get("probability") is not None), None)
    return None if found is None else float(found)


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
        return f"The plan began {start} the recording; their clocks run alike."
    pace = "gains" if drift_ppm > 0 else "loses"
    return f"The plan began {start} the recording; its clock {pace} {gained_ms:.0f} ms over the recording."
