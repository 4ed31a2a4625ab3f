"""Effects on the force. Sizes are over the force at the end of the stroke, or shares of the force."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.special import erf

from worlds_third import kernels
from worlds_third.effects.form import Form, form_of
from worlds_third.signals import Array, Signals

FORMS: list[Form] = []
_form = partial(form_of, FORMS, stage="mechanics", main="force", limit=0.9)
Rng = np.random.Generator


@_form("stress_relaxation", fast_s=(2.0, 20.0), slow_s=(60.0, 400.0), share=(0.2, 0.8))
def two_dashpots(s: Signals, size: float, rng: Rng, fast_s: float, slow_s: float, share: float) -> None:
    """Zener's solid with two relaxation times."""
    fast, slow = (kernels.follow(s.force, s.step_s, tau, tau, 0.0) for tau in (fast_s, slow_s))
    s.force = s.force - size * (share * fast + (1.0 - share) * slow)


@_form("stress_relaxation", order=(0.1, 0.4))
def springpot(s: Signals, size: float, rng: Rng, order: float) -> None:
    """A power of time (Scott Blair), as a ladder of dashpots over four decades."""
    taus = np.geomspace(0.3, 3000.0, 8)
    weights = taus**-order / np.sum(taus**-order)
    relaxed = sum(w * kernels.follow(s.force, s.step_s, tau, tau, 0.0) for w, tau in zip(weights, taus, strict=True))
    s.force = s.force - size * relaxed


@_form("stress_relaxation", tau_s=(20.0, 200.0), steepness=(3.0, 8.0))
def activated_flow(s: Signals, size: float, rng: Rng, tau_s: float, steepness: float) -> None:
    """Eyring's dashpot: relaxes quickly where the stress is high, hardly where it is low."""
    s.force = s.force - size * kernels.follow_activated(s.force, s.step_s, tau_s, steepness)


@_form("viscous_rate_stiffening", exponent=(0.4, 1.0))
def power_fluid(s: Signals, size: float, rng: Rng, exponent: float) -> None:
    """Ostwald and de Waele: a power of the rate, against the motion."""
    v = s.rate / s.usual_rate
    s.force = s.force + size * np.sign(v) * np.abs(v) ** exponent


@_form("viscous_rate_stiffening", slow=(0.02, 0.3))
def logarithmic_friction(s: Signals, size: float, rng: Rng, slow: float) -> None:
    """Prandtl and Eyring: the force rises with the logarithm of the rate, in proportion to itself."""
    s.force = s.force + size * s.force * np.arcsinh(s.rate / (slow * s.usual_rate)) / np.arcsinh(1 / slow)


@_form("viscous_rate_stiffening", tau_s=(0.2, 1.0))
def fast_maxwell(s: Signals, size: float, rng: Rng, tau_s: float) -> None:
    """A Maxwell element that lets go within a fraction of a second."""
    s.force = s.force + 5.0 * size * (s.strain - kernels.follow(s.strain, s.step_s, tau_s, tau_s, s.strain[0]))


@_form("mullins_softening", width=(0.1, 0.5), beta=(0.0, 0.3))
def pseudo_elastic(s: Signals, size: float, rng: Rng, width: float, beta: float) -> None:
    """Ogden and Roxburgh (1999): softer below the largest energy so far."""
    energy = np.maximum(s.force, 0.0) * np.maximum(s.strain, 0.0)
    largest = np.maximum.accumulate(energy)
    s.force = s.force * (1.0 - size * erf((largest - energy) / (width + beta * largest)))


@_form("mullins_softening", scale=(0.2, 1.0))
def broken_chains(s: Signals, size: float, rng: Rng, scale: float) -> None:
    """Simo (1987): a share of the stiffness goes with the largest stretch so far, and stays away."""
    s.force = s.force * (1.0 - size * (1.0 - np.exp(-np.maximum.accumulate(np.maximum(s.strain, 0.0)) / scale)))


@_form("cyclic_fatigue", strokes=(20.0, 200.0), exponent=(0.2, 0.6))
def by_travel(s: Signals, size: float, rng: Rng, strokes: float, exponent: float) -> None:
    """Rubbing: softens as a power of the travel, quickly at first."""
    s.force = s.force * (1.0 - size * (1.0 - (1.0 + 10 * s.travelled / strokes) ** -exponent))


@_form("cyclic_fatigue", exponent=(1.5, 4.0), number=(10.0, 100.0))
def by_turns(s: Signals, size: float, rng: Rng, exponent: float, number: float) -> None:
    """Coffin, Manson and Miner: every half-stroke adds damage by a power of its length."""
    damage = np.cumsum(kernels.half_strokes(s.strain, 0.03) ** exponent)
    s.force = s.force * (1.0 - size * (1.0 - np.exp(-damage / number)))


@_form("jamming_stiffening", onset=(0.45, 0.75), exponent=(1.5, 3.0))
def loops_lock(s: Signals, size: float, rng: Rng, onset: float, exponent: float) -> None:
    """Loops touch their neighbours: a second spring from there on."""
    s.force = s.force + 2 * size * (np.maximum(s.strain - onset, 0.0) / (1.0 - onset)) ** exponent


@_form("jamming_stiffening", pole=(1.12, 1.4))
def towards_a_pole(s: Signals, size: float, rng: Rng, pole: float) -> None:
    """No further than a geometric limit: the force has a pole there."""
    share = np.clip(s.strain / pole, 0.0, 0.98)
    s.force = s.force + size * share**6 / (1.0 - share**2)


@_form("thermal_softening")
def with_the_room(s: Signals, size: float, rng: Rng) -> None:
    """Softer in a warmer room."""
    s.force = s.force * (1.0 - 0.5 * size * s.room)


@_form("thermal_softening", lag_s=(30.0, 200.0))
def behind_the_room(s: Signals, size: float, rng: Rng, lag_s: float) -> None:
    """As the specimen's temperature, that follows the room's; exponential in it (Arrhenius, linearised)."""
    own: Array = kernels.follow(s.room, s.step_s, lag_s, lag_s, s.room[0])
    s.force = s.force * np.exp(-0.5 * size * own)
