"""The part of the C header that remembers motion and play; nothing where neither is used."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from compensation.compensator import Compensator
from compensation.history import SETTLE_S, History


def pieces(compensator: Compensator, name: str) -> dict[str, str]:
    """What goes into the state, the tables, the reset and the update; empty strings without a history."""
    history = compensator.history
    if not history.count:
        return dict.fromkeys(("history_state", "history_tables", "history_reset", "history_update"), "")
    return {
        "history_state": _state(history),
        "history_tables": _tables(history, compensator.rate_hz, name),
        "history_reset": "    s->settled = 0.0f;\n" + _each(history, "s->motion[i] = 0.0f;", "s->play[i] = 0.0f;"),
        "history_update": _update(history, len(compensator.alphas), name, name.upper()),
    }


def state_bytes(history: History) -> int:
    """RAM for it."""
    return 4 * (1 + history.count) if history.count else 0


def constants_bytes(history: History) -> int:
    """Flash for it: a time constant and a nominal gain a motion, a radius a play, one gain."""
    return 4 * (1 + 2 * len(history.motion_taus_s) + len(history.play_radii)) if history.count else 0


def multiplies(history: History) -> int:
    """Multiplications a sample at the nominal rate; the speed takes a division."""
    return len(history.motion_taus_s) + 2 if history.count else 0


def _state(history: History) -> str:
    lines = ["    float settled;                /* the lightly smoothed signal */"]
    if history.motion_taus_s:
        lines.append(f"    float motion[{len(history.motion_taus_s)}];              /* its smoothed speeds */")
    if history.play_radii:
        lines.append(f"    float play[{len(history.play_radii)}];                /* its play operators */")
    return "\n".join(lines) + "\n"


def _tables(history: History, rate_hz: float, name: str) -> str:
    def table(what: str, values: Iterable[float]) -> str:
        numbers = [f"{float(np.float32(value))!r}f" for value in values]
        return f"static const float {name}_{what}[{len(numbers)}] = {{{', '.join(numbers)}}};\n"

    taus_s = np.asarray(history.motion_taus_s)
    settle = float(np.float32(-np.expm1(-1.0 / (rate_hz * SETTLE_S))))
    text = f"static const float {name}_settle_gain = {settle!r}f;\n"
    if len(taus_s):
        text += table("per_s", -1.0 / taus_s) + table("motion_gain", -np.expm1(-1.0 / (rate_hz * taus_s)))
    if history.play_radii:
        text += table("play_radius", history.play_radii)
    return text


def _each(history: History, motion: str, play: str) -> str:
    loops = ((len(history.motion_taus_s), motion), (len(history.play_radii), play))
    return "".join(f"    for (int i = 0; i < {count}; i++) {body}\n" for count, body in loops if count)


def _update(history: History, at: int, name: str, upper: str) -> str:
    motions = len(history.motion_taus_s)
    play = (
        f"{{\n        const float r = {name}_play_radius[i], low = s->settled - r, high = s->settled + r;\n"
        "        if (s->play[i] < low || first) s->play[i] = first ? s->settled : low;\n"
        "        if (s->play[i] > high) s->play[i] = high;\n"
        f"        features[{at + motions} + i] = s->play[i];\n    }}"
    )
    motion = (
        f"{{\n        const float slow = nominal ? {name}_motion_gain[i] : {name}_gain({name}_per_s[i] * dt);\n"
        "        s->motion[i] += slow * (speed - s->motion[i]);\n"
        f"        features[{at} + i] = s->motion[i];\n    }}"
    )
    settle = f"nominal ? {name}_settle_gain : {name}_gain({float(np.float32(-1.0 / SETTLE_S))!r}f * dt)"
    return (
        f"    const float dt = nominal ? 1.0f / {upper}_RATE_HZ : (first ? 0.0f : dt_s);\n"
        f"    const float step = ({settle}) * (x - s->settled);\n"
        "    s->settled = first ? x : s->settled + step;\n"
        + ("    const float speed = dt > 0.0f ? (step < 0.0f ? -step : step) / dt : 0.0f;\n" if motions else "")
        + _each(history, motion, play)
    )
