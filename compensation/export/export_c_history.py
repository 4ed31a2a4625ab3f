"""The part of the C header that remembers motion and play; nothing where neither is used."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from compensation.memories.history import History
from compensation.model.compensator import TrainedCompensator
from compensation.model.runtime import beginning_of


def number(value: float) -> str:
    """A float constant of C, as its float32 is written."""
    return f"{float(np.float32(value))!r}f"


def pieces(compensator: TrainedCompensator, name: str) -> dict[str, str]:
    """What goes into the state, the tables, the reset and the update; empty strings without a history."""
    history = compensator.history
    if not history.count:
        return dict.fromkeys(("history_state", "history_tables", "history_reset", "history_update"), "")
    return {
        "history_state": _state(history),
        "history_tables": _tables(compensator, name),
        "history_reset": "    s->settled = 0.0f;\n    s->settled_lost = 0.0f;\n"
        + _each(history, "{ s->motion[i] = 0.0f; }", "{ s->play[i] = 0.0f; }"),
        "history_update": _update(history, len(compensator.alphas), name, name.upper()),
    }


def state_bytes(history: History) -> int:
    """Bytes of RAM that the history's state takes."""
    return 4 * (2 + history.count) if history.count else 0


def constants_bytes(history: History) -> int:
    """Bytes of flash that the history's constants take: four numbers a motion, three a play, one gain."""
    return 4 * (1 + 4 * len(history.motion_taus_s) + 3 * len(history.play_radii)) if history.count else 0


def multiplies(history: History) -> int:
    """Multiplications a sample at the nominal rate; the speed takes a division."""
    return 2 * len(history.motion_taus_s) + len(history.play_radii) + 2 if history.count else 0


def _state(history: History) -> str:
    lines = [
        "    float settled;                /* the lightly smoothed signal */",
        "    float settled_lost;           /* what rounding has taken from it */",
    ]
    if history.motion_taus_s:
        lines.append(f"    float motion[{len(history.motion_taus_s)}];              /* its smoothed speeds */")
    if history.play_radii:
        lines.append(f"    float play[{len(history.play_radii)}];                /* its play operators */")
    return "\n".join(lines) + "\n"


def _tables(compensator: TrainedCompensator, name: str) -> str:
    history, rate_hz, filters = compensator.history, compensator.rate_hz, len(compensator.alphas)
    begin, motions = beginning_of(compensator), len(compensator.history.motion_taus_s)

    def table(what: str, values: Iterable[float]) -> str:
        numbers = [number(value) for value in values]
        return f"static const float {name}_{what}[{len(numbers)}] = {{{', '.join(numbers)}}};\n"

    taus_s = np.asarray(history.motion_taus_s)
    settle = number(-np.expm1(-1.0 / (rate_hz * history.settle_s)))
    text = f"static const float {name}_settle_gain = {settle};\n"
    if len(taus_s):
        text += table("per_s", -1.0 / taus_s) + table("motion_gain", -np.expm1(-1.0 / (rate_hz * taus_s)))
        text += table("motion_begin_gain", begin.gain[filters : filters + motions])
        text += table("motion_begin_offset", begin.offset[filters : filters + motions])
    if history.play_radii:
        text += table("play_radius", history.play_radii)
        text += table("play_begin_gain", begin.gain[filters + motions :])
        text += table("play_begin_offset", begin.offset[filters + motions :])
    return text


def _each(history: History, motion: str, play: str) -> str:
    loops = ((len(history.motion_taus_s), motion), (len(history.play_radii), play))
    return "".join(f"    for (uint32_t i = 0u; i < {count}u; i++) {body}\n" for count, body in loops if count)


def _update(history: History, at: int, name: str, upper: str) -> str:
    motions = len(history.motion_taus_s)
    play = (
        f"{{\n        const float r = {name}_play_radius[i], low = s->settled - r, high = s->settled + r;\n"
        f"        if (first != 0u) {{\n"
        f"            s->play[i] = {name}_play_begin_offset[i] + ({name}_play_begin_gain[i] * x);\n        }}\n"
        "        s->play[i] = (s->play[i] < low) ? low : s->play[i];\n"
        "        s->play[i] = (s->play[i] > high) ? high : s->play[i];\n"
        f"        features[{at + motions}u + i] = s->play[i];\n    }}"
    )
    motion = (
        "{\n"
        f"        const float slow = (nominal != 0u) ? {name}_motion_gain[i] : {name}_gain({name}_per_s[i] * dt);\n"
        f"        const float begun = {name}_motion_begin_offset[i] + ({name}_motion_begin_gain[i] * x);\n"
        "        s->motion[i] = (first != 0u) ? begun : (s->motion[i] + (slow * (speed - s->motion[i])));\n"
        f"        features[{at}u + i] = s->motion[i];\n    }}"
    )
    settle = f"(nominal != 0u) ? {name}_settle_gain : {name}_gain({number(-1.0 / history.settle_s)} * dt)"
    return (
        f"    const float dt = (nominal != 0u) ? (1.0f / {upper}_RATE_HZ) : ((first != 0u) ? 0.0f : dt_s);\n"
        f"    const float moved = ({settle}) * (x - s->settled);\n"
        "    const float step = moved - s->settled_lost;\n"
        "    const float next = s->settled + step;\n"
        "    s->settled_lost = (first != 0u) ? 0.0f : ((next - s->settled) - step);\n"
        "    s->settled = (first != 0u) ? x : next;\n"
        + (
            "    const float speed = (dt > 0.0f) ? (((moved < 0.0f) ? -moved : moved) / dt) : 0.0f;\n"
            if motions
            else ""
        )
        + _each(history, motion, play)
    )
