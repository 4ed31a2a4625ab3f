"""The part of the C header that remembers motion and play; nothing where neither is used."""

from __future__ import annotations

from collections.abc import Iterable
from string import Template

import numpy as np

from compensation.export.c_template import (
    MOTION_RESET,
    MOTION_STATE,
    MOTION_UPDATE,
    PLAY_RESET,
    PLAY_STATE,
    PLAY_UPDATE,
    SETTLED_RESET,
    SETTLED_STATE,
    SETTLED_UPDATE,
)
from compensation.memories.history import History
from compensation.model.compensator import TrainedCompensator
from compensation.model.runtime import beginning_of


def number(value: float) -> str:
    """A float constant of C, as its float32 is written."""
    return f"{float(np.float32(value))!r}f"


def pieces(compensator: TrainedCompensator, name: str) -> dict[str, str]:
    """What goes into the state, the tables, the reset and the update; empty strings without a history."""
    history, filters = compensator.history, len(compensator.alphas)
    if not history.count:
        return dict.fromkeys(("history_state", "history_tables", "history_reset", "history_update"), "")
    motions, plays = len(history.motion_taus_s), len(history.play_radii)
    filled = {
        "name": name,
        "NAME": name.upper(),
        "motions": motions,
        "plays": plays,
        "filters": filters,
        "first_play": filters + motions,
        "per_settle": number(-1.0 / history.settle_s),
    }

    def text(settled: Template, motion: Template, play: Template) -> str:
        used = [settled] + ([motion] if motions else []) + ([play] if plays else [])
        return "".join(part.substitute(filled) for part in used)

    return {
        "history_state": text(SETTLED_STATE, MOTION_STATE, PLAY_STATE),
        "history_tables": _tables(compensator, name),
        "history_reset": text(SETTLED_RESET, MOTION_RESET, PLAY_RESET),
        "history_update": text(SETTLED_UPDATE, MOTION_UPDATE, PLAY_UPDATE),
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
