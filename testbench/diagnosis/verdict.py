"""The verdict of a diagnosis in words, for the terminal and every page; made from its JSON, with nothing computed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from testbench.comparing.carried_over import CLEARLY, LEFT_AT_MOST, changed, fails_elsewhere
from testbench.comparing.words import listed, percent, spoken, still_off
from testbench.knit.effect_names import HYPOTHESES

NOTHING, UNKNOWN = HYPOTHESES


def verdict_clauses(diagnosis: Mapping[str, Any]) -> list[str]:
    """All that was found and how sure that is, what is left, and what speaks against it: a clause each.

    Parameters
    ----------
    diagnosis : mapping
        The JSON of ``testbench diagnose``.
    """
    if diagnosis["verdict"] == "unknown":
        return _unknown(diagnosis)
    history = diagnosis.get("history", ())
    fails = fails_elsewhere(history, len(diagnosis["found"])) if history else ""
    if diagnosis["verdict"] == "missing":
        here = " in this recording" if fails else ""
        said = [f"missing: {_found(diagnosis)}", f"{_left(diagnosis)} is left{_where(diagnosis)}{here}"]
    else:
        here = "in this recording" if fails else "that these recordings could show"
        said = [f"nothing is missing {here} ({percent(diagnosis['probabilities'][NOTHING])})", *_bent(diagnosis)]
    off = still_off(diagnosis["error_after"], diagnosis["noise_floor"])
    but = fails or (off and f"{off}; a comparison shows where")
    return [*said, f"but {but}"] if but else said


def with_probability(diagnosis: Mapping[str, Any], effect: str) -> str:
    """``stress relaxation (97 %)``: how probable it is that this is what is missing most."""
    return f"{spoken(effect)} ({percent(diagnosis['probabilities'][effect])})"


def _unknown(diagnosis: Mapping[str, Any]) -> list[str]:
    """That no effect explains enough; of the first one, what it would leave."""
    unknown, first = diagnosis["probabilities"][UNKNOWN], next(iter(diagnosis["ranking"]), None)
    if first and first["probability"] > unknown:
        probable = with_probability(diagnosis, first["effect"])
        said = [f"unknown: {probable} is probable, but leaves {_share(first['error_share_left'])}"]
        return said + _depends(diagnosis)
    said = [f"unknown ({percent(unknown)}): something is missing that no effect of the catalogue explains"]
    return said + _depends(diagnosis) + _nearest(first)


def _depends(diagnosis: Mapping[str, Any]) -> list[str]:
    most = [
        f"{entry['channel']} on {spoken(entry['coordinate'])} ({percent(entry['gain'])} of it)"
        for entry in diagnosis.get("depends_on", [])[:2]
    ]
    return [f"what is left depends most on this: {listed(most)}"] if most else []


def _nearest(first: Mapping[str, Any] | None) -> list[str]:
    """What is said of the most probable law where none is probable: it may be a part of the answer."""
    if first is None or not first.get("held_out_gain") or first["error_share_left"] > CLEARLY:
        return []
    law = f" ({spoken(first['law'])})" if first["law"] != first["effect"] else ""
    return [f"the nearest is {spoken(first['effect'])}{law}, which would leave {_share(first['error_share_left'])}"]


def _bent(diagnosis: Mapping[str, Any]) -> list[str]:
    """As which effect a law of the base is bent, if it is; that is no news, but it is what the base lacks."""
    bend = diagnosis.get("bends_like")
    return [f"but a law of the base is bent as {with_probability(diagnosis, bend)} would bend it"] if bend else []


def _found(diagnosis: Mapping[str, Any]) -> str:
    found = diagnosis["found"]
    words = [f"{spoken(one['effect'])} ({percent(one['probability'])})" for one in found]
    rivals = [with_probability(diagnosis, name) for name in diagnosis.get("tied", ()) if name != found[0]["effect"]]
    if rivals:
        words[0] += f", hardly told from {listed(rivals)}"
    return ", then ".join(words)


def _left(diagnosis: Mapping[str, Any]) -> str:
    left = diagnosis.get("left_unexplained", 1.0)
    return _share(left) if left >= 0.01 else "less than 1 % of the error above the noise"


def _where(diagnosis: Mapping[str, Any]) -> str:
    """In which channel most is left, where what was found explains another one."""
    history = diagnosis.get("history")
    if not history or diagnosis.get("left_unexplained", 1.0) <= LEFT_AT_MOST:
        return ""
    where = changed(history, len(diagnosis["found"]))
    others = [channel for channel in history[-1]["errors"]["calibration"] if channel not in where]
    return f", nearly all of it in the {others[0]}" if others else ""


def _share(left: float) -> str:
    return f"{100 * left:.0f} % of the error above the noise"
