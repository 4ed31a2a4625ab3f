"""What happens between the motor and the sample: the strain of the sample is not what the displacement says."""

from __future__ import annotations

import numpy as np

from worlds_second.chain import Signals
from worlds_second.draws import lin, log, pick
from worlds_second.effects.registry import form
from worlds_second.kernels import Array, lag, play, play_stack, turns

AT = "kinematics"


def highest(s: Signals) -> Array:
    """Largest strain so far."""
    return np.maximum.accumulate(np.maximum(s.e, 0.0))


def above(x: Array, edge: float) -> Array:
    """How far a signal lies above an edge."""
    return np.maximum(x - edge, 0.0)


def moments(s: Signals, rng: np.random.Generator, while_: Array, mean_s: float) -> Array:
    """Random samples (at least one) at which something happens while a condition holds, none where it never does."""
    exposure = np.cumsum(while_ * s.dt)
    count = 1 + int(rng.poisson(0.3 * s.t[-1] / mean_s))
    return np.searchsorted(exposure, np.sort(rng.uniform(0.0, 1.0, count)) * exposure[-1], side="right")


def stairs(s: Signals, at: Array, heights: Array) -> Array:
    """The sum of all steps so far."""
    steps = np.zeros(len(s.t) + 1)
    np.add.at(steps, at, heights)
    return np.cumsum(steps[:-1])


@form("permanent_set", AT, 0.5, edge=lin(0.0, 0.3), power=lin(1.0, 2.2))
def after_largest(s: Signals, m: float, edge: float, power: float) -> Array:
    """The sample stays longer after each new largest stretch."""
    return s.e - m * above(highest(s), edge) ** power


@form("permanent_set", AT, 0.5, time_s=log(40.0, 500.0), power=lin(1.0, 3.0))
def sagging(s: Signals, m: float, time_s: float, power: float) -> Array:
    """The sample sags under stretch and takes as long to come back."""
    return s.e - m * lag(np.maximum(s.e, 0.0) ** power, s.dt, time_s, start=0.0)


@form("permanent_set", AT, 0.5, whole_strokes=log(5.0, 120.0), edge=lin(0.0, 0.5))
def ratchet(s: Signals, m: float, whole_strokes: float, edge: float) -> Array:
    """Each pull above an edge draws a little yarn along, ever less."""
    pulls = np.cumsum(np.maximum(np.diff(s.e, prepend=s.e[0]), 0.0) * (s.e > edge))
    return s.e + m * np.expm1(-pulls / whole_strokes)


@form("permanent_set", AT, 0.5, time_s=log(5.0, 100.0), power=lin(1.0, 3.0))
def logarithmic_creep(s: Signals, m: float, time_s: float, power: float) -> Array:
    """Time under stretch makes the sample longer, the same for each decade of it."""
    return s.e - m * np.log1p(np.cumsum(np.maximum(s.e, 0.0) ** power * s.dt) / time_s)


@form("clamp_slip", AT, 0.5, first=lin(0.3, 0.5), gap=lin(0.08, 0.2))
def jumps_at_new_largest(s: Signals, m: float, first: float, gap: float) -> Array:
    """The clamp gives way by a jump at a row of new largest stretches."""
    return s.e - m * np.maximum(np.floor((highest(s) - first) / gap) + 1.0, 0.0)


@form("clamp_slip", AT, 0.3, grip=lin(0.45, 0.7), mean_s=log(30.0, 300.0))
def random_jerks(s: Signals, m: float, grip: float, mean_s: float) -> Array:
    """Above a grip the fabric jerks out now and then, by random lengths."""
    at = moments(s, s.chance, s.e > grip, mean_s)
    lengths = s.chance.exponential(1.0, len(at)) + 0.2
    return s.e - m * stairs(s, at, lengths)


@form("clamp_slip", AT, 0.5, grip=lin(0.35, 0.75), power=lin(1.0, 2.0))
def creeping_out(s: Signals, m: float, grip: float, power: float) -> Array:
    """The fabric slides steadily as long as the pull is above the grip."""
    minutes = np.cumsum(above(s.e, grip) ** power * s.dt) / 60.0
    return s.e - m * minutes


@form("clamp_slip", AT, 0.5, share=lin(0.15, 0.7), time_s=log(0.05, 1.0))
def one_yield(s: Signals, m: float, share: float, time_s: float) -> Array:
    """At one moment the clamp yields once and for all."""
    when = (share + s.chance.uniform(-0.1, 0.1)) * s.t[-1]
    return s.e + m * np.expm1(-above(s.t, when) / time_s)


@form("actuator_backlash", AT, 0.3)
def dead_travel(s: Signals, m: float) -> Array:
    """After a turn the sample stands still until the play of the nut is used up."""
    return play(s.e, m)


@form("actuator_backlash", AT, 0.3, free=lin(0.3, 0.8), second=lin(0.15, 0.5))
def preloaded_nut(s: Signals, m: float, free: float, second: float) -> Array:
    """Two flanks of the thread let go one after the other."""
    return play_stack(s.e, np.array([m, second * m]), np.array([free, 1.0 - free]))


@form("actuator_backlash", AT, 0.3, sign=pick(-1.0, 1.0))
def wrongly_compensated(s: Signals, m: float, sign: float) -> Array:
    """The controller adds a step at each turn, for a play that is not there."""
    side = turns(s.e, 1e-6)[2]
    return s.e + sign * 0.5 * m * side


@form("leadscrew_ripple", AT, 0.1, threads=log(5.0, 25.0), phase=lin(0.0, 6.283))
def eccentric(s: Signals, m: float, threads: float, phase: float) -> Array:
    """Once per turn of the screw the nut runs ahead and behind."""
    return s.e + m * np.sin(2 * np.pi * threads * s.motion.x + phase)


@form("leadscrew_ripple", AT, 0.1, threads=log(4.0, 12.0), phase=lin(0.0, 6.283), second=lin(0.3, 0.9))
def eccentric_and_wobbling(s: Signals, m: float, threads: float, phase: float, second: float) -> Array:
    """An error once per turn and another twice per turn."""
    turn = 2 * np.pi * threads * s.motion.x + phase
    return s.e + m * (np.sin(turn) + second * np.sin(2 * turn + 1.7 * phase))


@form("leadscrew_ripple", AT, 0.1, threads=log(4.0, 15.0), phase=lin(0.0, 1.0))
def worn_thread(s: Signals, m: float, threads: float, phase: float) -> Array:
    """A rounded saw-tooth of the travel."""
    turn = 2 * np.pi * (threads * s.motion.x + phase)
    return s.e + m * np.arctan2(0.8 * np.sin(turn), 1.0 - 0.8 * np.cos(turn))


@form("slack", AT, 0.8)
def loose(s: Signals, m: float) -> Array:
    """Nothing happens until the sample is straight."""
    return np.maximum(s.e - m, 0.0)


@form("slack", AT, 0.8, width=log(0.01, 0.06))
def crumpled(s: Signals, m: float, width: float) -> Array:
    """A crumpled sample straightens little by little."""
    return width * np.logaddexp(0.0, (s.e - m) / width)


@form("slack", AT, 0.8, sharp=lin(2.0, 6.0))
def sagging_loop(s: Signals, m: float, sharp: float) -> Array:
    """A sagging sample takes up its loop by a power law."""
    e = np.maximum(s.e, 0.0)
    return (e**sharp + m**sharp) ** (1.0 / sharp) - m
