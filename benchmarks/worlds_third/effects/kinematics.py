"""Effects on the strain that the knit really sees. Sizes are over the stroke."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_third import kernels
from worlds_third.effects.form import Form, form_of
from worlds_third.signals import Array, Signals

FORMS: list[Form] = []
_form = partial(form_of, FORMS, stage="kinematics", main="both", limit=0.4)
Rng = np.random.Generator


@_form("permanent_set", yield_strain=(0.2, 0.6), flow_s=(60.0, 600.0))
def flow_above_yield(s: Signals, size: float, rng: Rng, yield_strain: float, flow_s: float) -> None:
    """Flows towards a final set while stretched beyond a yield strain (Bingham)."""
    over = np.maximum(s.strain - yield_strain, 0.0) / (1.0 - yield_strain)
    s.strain = s.strain - size * kernels.approach(over * s.step_s / flow_s)


@_form("permanent_set", exponent=(1.0, 2.5), reach=(0.05, 0.3))
def share_of_largest(s: Signals, size: float, rng: Rng, exponent: float, reach: float) -> None:
    """A share of the largest stretch so far stays, worked in over a short travel."""
    largest = np.maximum.accumulate(np.maximum(s.strain, 0.0)) ** exponent
    moved = np.abs(np.diff(s.strain, prepend=s.strain[0]))
    s.strain = s.strain - size * kernels.follow(largest, moved, reach, reach, 0.0)


@_form("permanent_set", exponent=(1.0, 3.0), hardening=(0.2, 0.6))
def viscous_length(s: Signals, size: float, rng: Rng, exponent: float, hardening: float) -> None:
    """A dashpot in series that hardens: length grows with a power of the time under stretch."""
    impulse = np.cumsum(np.maximum(s.strain, 0.0) ** exponent * s.step_s) / 300.0
    s.strain = s.strain - size * impulse**hardening


@_form("clamp_slip", jerks=(2.0, 6.0), grip=(0.5, 0.8))
def few_jerks(s: Signals, size: float, rng: Rng, jerks: float, grip: float) -> None:
    """The jaw lets go a few times, at any moments of strong pull, by lengths that differ."""
    strong = np.flatnonzero(s.drive > grip * s.drive.max())
    at = np.sort(rng.choice(strong, size=int(jerks), replace=False))
    lengths = rng.exponential(size=len(at))
    s.strain = s.strain - size * _steps(len(s.strain), at, lengths / lengths.sum())


@_form("clamp_slip", grip=(0.5, 0.85), exponent=(1.0, 2.0))
def creeping_jaw(s: Signals, size: float, rng: Rng, grip: float, exponent: float) -> None:
    """Slides slowly for as long as the pull is above what the jaw holds."""
    speed = np.maximum(s.drive - grip * s.drive.max(), 0.0) ** exponent
    path = np.cumsum(speed * s.step_s)
    s.strain = s.strain - size * path / path[-1]


@_form("clamp_slip", first=(0.3, 0.5), spacing=(0.04, 0.12))
def at_new_records(s: Signals, size: float, rng: Rng, first: float, spacing: float) -> None:
    """Gives way a little each time the stretch passes the next mark it has not passed before."""
    record = np.maximum.accumulate(s.drive)
    marks = np.floor(np.maximum(record - first, -1e-9) / spacing) + 1.0
    s.strain = s.strain - size * marks / (np.floor((1.0 - first) / spacing) + 1.0)


@_form("actuator_backlash")
def dead_nut(s: Signals, size: float, rng: Rng) -> None:
    """A nut with play: nothing follows the spindle until the gap is crossed."""
    s.strain = kernels.play(s.strain, size)


@_form("actuator_backlash", reach=(0.02, 0.08))
def wound_up(s: Signals, size: float, rng: Rng, reach: float) -> None:
    """Belt and bearings wind up against friction: late by a length that grows over a short travel."""
    s.strain = s.strain - size * kernels.direction(s.strain, reach)


@_form("leadscrew_ripple", turns=(5.0, 25.0), phase=(0.0, 6.28))
def bent_screw(s: Signals, size: float, rng: Rng, turns: float, phase: float) -> None:
    """Once a turn ahead, once behind."""
    s.strain = s.strain + size * np.sin(2 * np.pi * turns * s.drive + phase)


@_form("leadscrew_ripple", turns=(4.0, 12.0), phase=(0.0, 6.28), teeth=(2.0, 4.0), share=(0.3, 0.8))
def coupled_screw(s: Signals, size: float, rng: Rng, turns: float, phase: float, teeth: float, share: float) -> None:
    """Once a turn, and a few times a turn besides, as from a worn coupling."""
    angle = 2 * np.pi * turns * s.drive
    s.strain = s.strain + size * (np.sin(angle + phase) + share * np.sin(np.floor(teeth) * angle - phase))


@_form("slack")
def limp_start(s: Signals, size: float, rng: Rng) -> None:
    """Nothing happens until the slack is out."""
    s.strain = np.maximum(s.strain - size, -0.05) * (1.0 / (1.0 - size)) if size > 0 else s.strain


@_form("slack", softness=(0.1, 0.3))
def curled_start(s: Signals, size: float, rng: Rng, softness: float) -> None:
    """The curled edges unroll: the first stretch is only partly stretch."""
    width = softness * size + 1e-9
    limp = width * (np.logaddexp(0.0, (s.strain - size) / width) - np.logaddexp(0.0, -size / width))
    s.strain = limp / (1.0 - size) + np.minimum(s.strain, 0.0)


def _steps(count: int, at: Array, lengths: Array) -> Array:
    jumps = np.zeros(count)
    np.add.at(jumps, at, lengths)
    return np.cumsum(jumps)
