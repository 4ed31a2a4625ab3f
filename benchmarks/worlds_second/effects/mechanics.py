"""What the fabric does to the force, and with it to the pressure on its contacts."""

from __future__ import annotations

import numpy as np
from scipy.special import erf

from worlds_second.chain import Signals
from worlds_second.draws import lin, log
from worlds_second.effects.kinematics import above, highest
from worlds_second.effects.registry import form
from worlds_second.kernels import Array, lag, turns

AT = "mechanics"
SMALLEST_SWING = 0.03


@form("stress_relaxation", AT, 0.9, time_s=log(2.0, 200.0))
def maxwell_arm(s: Signals, m: float, time_s: float) -> Array:
    """A share of the force relaxes with one time."""
    return s.f - m * lag(s.f, s.dt, time_s, start=0.0)


@form("stress_relaxation", AT, 0.9, first_s=log(0.5, 5.0), decades=lin(1.5, 3.0), tilt=lin(-0.3, 0.3))
def many_arms(s: Signals, m: float, first_s: float, decades: float, tilt: float) -> Array:
    """A share of the force relaxes over decades of time."""
    steps = np.linspace(0.0, 1.0, 7)
    weights = 10.0 ** (tilt * decades * (steps - 0.5))
    arms = [
        w * lag(s.f, s.dt, first_s * 10.0 ** (decades * k), start=0.0) for k, w in zip(steps, weights, strict=True)
    ]
    return s.f - m * np.sum(arms, axis=0) / weights.sum()


@form("stress_relaxation", AT, 0.9, time_s=log(5.0, 120.0), hurry=lin(1.0, 4.0))
def activated(s: Signals, m: float, time_s: float, hurry: float) -> Array:
    """The higher the force the sooner it relaxes."""
    return s.f - m * lag(s.f, s.dt, time_s * np.exp(-hurry * np.clip(s.f, -1.0, 2.0)), start=0.0)


@form("stress_relaxation", AT, 0.9, time_s=log(2.0, 150.0), power=lin(0.8, 2.0))
def sliding_loops(s: Signals, m: float, time_s: float, power: float) -> Array:
    """The loops of yarn rearrange after the strain, whatever the force."""
    return s.f - m * lag(s.e**power, s.dt, time_s, start=0.0)


@form("viscous_rate_stiffening", AT, 0.8, power=lin(0.25, 1.0))
def power_of_rate(s: Signals, m: float, power: float) -> Array:
    """A force with the sign of the rate, a power of it."""
    return s.f + m * np.sign(s.rate) * np.abs(s.rate) ** power


@form("viscous_rate_stiffening", AT, 0.8, knee=log(0.01, 0.3))
def thermally_activated(s: Signals, m: float, knee: float) -> Array:
    """Eyring's inverse hyperbolic sine of the rate."""
    return s.f + m * np.arcsinh(s.rate / knee) / np.arcsinh(1.0 / knee)


@form("viscous_rate_stiffening", AT, 0.8, knee=log(0.2, 2.0), power=lin(0.5, 1.5))
def rubbing_yarns(s: Signals, m: float, knee: float, power: float) -> Array:
    """Rubbing that grows with force and levels off with the rate."""
    return s.f + m * np.maximum(s.f, 0.0) ** power * np.tanh(s.rate / knee)


@form("mullins_softening", AT, 0.9, scale=log(0.2, 1.5))
def lasting_damage(s: Signals, m: float, scale: float) -> Array:
    """After each new largest stretch the fabric is softer at every strain."""
    return s.f * (1.0 + m * np.expm1(-highest(s) / scale))


@form("mullins_softening", AT, 0.9, width=log(0.1, 0.6))
def virgin_curve(s: Signals, m: float, width: float) -> Array:
    """Softer the further below its largest force (after Ogden and Roxburgh 1999)."""
    return s.f * (1.0 - m * erf((np.maximum.accumulate(s.f) - s.f) / width))


@form("mullins_softening", AT, 0.9, power=lin(0.5, 2.5))
def below_largest(s: Signals, m: float, power: float) -> Array:
    """Shorter stretches need less force, until the largest is reached again."""
    share = np.clip(s.e / np.maximum(highest(s), 1e-6), 0.0, 1.0)
    return s.f * (1.0 - m * (1.0 - share**power))


@form("cyclic_fatigue", AT, 0.9, swings=log(1.0, 20.0))
def decade_of_cycles(s: Signals, m: float, swings: float) -> Array:
    """Each tenfold number of cycles costs the same share."""
    return s.f * (1.0 - m * np.log10(1.0 + turns(s.e, SMALLEST_SWING)[0] / swings))


@form("cyclic_fatigue", AT, 0.9, strokes=log(10.0, 150.0))
def worn_in(s: Signals, m: float, strokes: float) -> Array:
    """Every stroke costs a little, until the fabric is worn in."""
    return s.f * (1.0 + m * np.expm1(-s.travel / strokes))


@form("cyclic_fatigue", AT, 20.0, edge=lin(0.3, 0.6), power=lin(1.0, 2.0))
def large_cycles(s: Signals, m: float, edge: float, power: float) -> Array:
    """Only pulls to high strain tire the fabric (Basquin's power)."""
    pulls = np.maximum(np.diff(s.e, prepend=s.e[0]), 0.0)
    tired = np.cumsum(pulls * above(s.e, edge) ** power)
    return s.f / (1.0 + m * tired)


@form("jamming_stiffening", AT, 500.0, edge=lin(0.55, 0.8), power=lin(1.0, 2.0))
def loops_jam(s: Signals, m: float, edge: float, power: float) -> Array:
    """Above an edge the loops lie on each other."""
    return s.f + m * above(s.e, edge) ** power


@form("jamming_stiffening", AT, 5.0, wall=lin(1.1, 1.3), edge=lin(0.5, 0.7))
def towards_a_wall(s: Signals, m: float, wall: float, edge: float) -> Array:
    """Above an edge a force that would have no end at a wall."""
    near = np.clip(wall - s.e, 0.02, None)
    return s.f + m * above((wall - edge) / near, 1.0)


@form("jamming_stiffening", AT, 20.0, edge=lin(0.5, 0.75), width=lin(0.02, 0.06))
def rounded_jam(s: Signals, m: float, edge: float, width: float) -> Array:
    """A second slope that comes in within a small strain."""
    return s.f + m * width * np.logaddexp(0.0, (s.e - edge) / width)


@form("thermal_softening", AT, 0.2)
def room(s: Signals, m: float) -> Array:
    """Force sinks in proportion as the room warms."""
    return s.f * np.exp(-m * s.room_K)


@form("thermal_softening", AT, 0.2, time_s=log(20.0, 200.0))
def fabric_lags_room(s: Signals, m: float, time_s: float) -> Array:
    """The fabric warms later than the room."""
    return s.f * (1.0 - m * lag(s.room_K, s.dt, time_s))


@form("thermal_softening", AT, 0.3, scale_K=log(1.0, 6.0))
def softening_point(s: Signals, m: float, scale_K: float) -> Array:
    """Stiffness falls along a bend, as near a glass transition."""
    return s.f * (1.0 - m * scale_K * np.tanh((s.room_K + 0.5) / scale_K))
