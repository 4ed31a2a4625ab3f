"""Effects on the resistance itself. Sizes are of ln G."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_third import kernels
from worlds_third.effects.form import Form, form_of
from worlds_third.signals import Signals

FORMS: list[Form] = []
_form = partial(form_of, FORMS, stage="electrical", main="conductance", limit=3.0)
Rng = np.random.Generator


@_form("coating_wear", exponent=(0.5, 2.0))
def archard(s: Signals, size: float, rng: Rng, exponent: float) -> None:
    """Wear by load times travel (Archard, 1953)."""
    moved = np.abs(np.diff(s.strain, prepend=s.strain[0]))
    s.log_g = s.log_g - size * np.cumsum(moved * np.maximum(s.pressure, 0.0) ** exponent) / 100.0


@_form("coating_wear", number=(10.0, 80.0))
def polishing(s: Signals, size: float, rng: Rng, number: float) -> None:
    """Each half-stroke takes its share of what is left to be rubbed off."""
    worn = np.cumsum(kernels.half_strokes(s.strain, 0.03))
    s.log_g = s.log_g - size * (1.0 - np.exp(-worn / number))


@_form("coating_cracks", onset=(0.1, 0.5), exponent=(0.8, 2.0))
def at_largest_stretch(s: Signals, size: float, rng: Rng, onset: float, exponent: float) -> None:
    """Cracks in number as the largest stretch so far is beyond an onset; they never heal."""
    s.log_g = s.log_g - size * np.maximum(np.maximum.accumulate(s.strain) - onset, 0.0) ** exponent


@_form("coating_cracks", cracks=(6.0, 15.0), key=(0.0, 1e6))
def one_by_one(s: Signals, size: float, rng: Rng, cracks: float, key: float) -> None:
    """A few cracks, each at a stretch of its own and of a size of its own; they open with strain."""
    own = np.random.default_rng(int(key))
    at, sizes = own.uniform(0.15, 0.97, int(cracks)), own.exponential(1.0, int(cracks))
    order = np.argsort(at)
    total = np.concatenate([[0.0], np.cumsum(sizes[order])]) / sizes.sum()
    broken = total[np.searchsorted(at[order], np.maximum.accumulate(s.strain))]
    s.log_g = s.log_g - size * broken * (0.5 + 0.5 * np.clip(s.strain, 0.0, 1.2))


@_form("yarn_elongation", onset=(0.4, 0.75))
def longer_path(s: Signals, size: float, rng: Rng, onset: float) -> None:
    """The yarn itself is stretched once the loops are straight."""
    s.log_g = s.log_g - size * (np.maximum(s.strain - onset, 0.0) / (1.0 - onset)) ** 2


@_form("yarn_elongation", exponent=(4.0, 7.0))
def thinner_yarn(s: Signals, size: float, rng: Rng, exponent: float) -> None:
    """Longer and thinner: resistance as the square of the yarn's own stretch, which comes late."""
    s.log_g = s.log_g - 2.0 * np.log1p(0.5 * size * np.maximum(s.strain, 0.0) ** exponent)


@_form("electrical_overshoot", tau_s=(1.0, 10.0), sign=(-1.0, 2.0))
def beyond_and_back(s: Signals, size: float, rng: Rng, tau_s: float, sign: float) -> None:
    """Shoots beyond with the strain, and comes back."""
    ahead = s.strain - kernels.follow(s.strain, s.step_s, tau_s, tau_s, s.strain[0])
    s.log_g = s.log_g + (1.0 if sign > 0 else -1.0) * size * ahead


@_form("electrical_overshoot", tau_s=(1.0, 12.0), sign=(-2.0, 1.0))
def stirred_contacts(s: Signals, size: float, rng: Rng, tau_s: float, sign: float) -> None:
    """Motion in either direction disturbs the contacts; they come to rest within seconds."""
    stir = np.tanh(np.abs(s.rate) / s.usual_rate)
    s.log_g = s.log_g + (1.0 if sign > 0 else -1.0) * size * kernels.follow(stir, s.step_s, 0.3, tau_s, 0.0)


@_form("electrical_overshoot", tau_s=(1.0, 12.0))
def of_its_own_change(s: Signals, size: float, rng: Rng, tau_s: float) -> None:
    """A share of every change of ln G is given back."""
    s.log_g = s.log_g + size * (s.log_g - kernels.follow(s.log_g, s.step_s, tau_s, tau_s, s.log_g[0]))


@_form("rate_resistance", exponent=(0.5, 1.2), sign=(-1.0, 1.0))
def with_speed(s: Signals, size: float, rng: Rng, exponent: float, sign: float) -> None:
    """Shifted while it moves, one way out and the other way back."""
    v = s.rate / s.usual_rate
    s.log_g = s.log_g + (1.0 if sign > 0 else -1.0) * size * np.sign(v) * np.abs(v) ** exponent


@_form("rate_resistance", slow=(0.1, 1.0))
def with_pace(s: Signals, size: float, rng: Rng, slow: float) -> None:
    """Shifted the same way in both directions, by the logarithm of the speed."""
    s.log_g = s.log_g - size * np.log1p(np.abs(s.rate) / (slow * s.usual_rate))


@_form("shoulder_peak", centre=(0.3, 0.7), width=(0.06, 0.15))
def bump_on_return(s: Signals, size: float, rng: Rng, centre: float, width: float) -> None:
    """A second peak of the resistance on the way back."""
    back = 0.5 * (1.0 - kernels.direction(s.strain, 0.03))
    s.log_g = s.log_g - size * back * np.exp(-(((s.strain - centre) / width) ** 2))


@_form("shoulder_peak", below=(0.1, 0.3), width=(0.05, 0.12))
def bump_after_turn(s: Signals, size: float, rng: Rng, below: float, width: float) -> None:
    """Loops slide back in one go, a fixed way after the turn, more from far out."""
    top = kernels.follow(s.strain, np.abs(np.diff(s.strain, prepend=0.0)), 1e-4, 0.5, 0.0)
    way = top - s.strain
    back = 0.5 * (1.0 - kernels.direction(s.strain, 0.03))
    s.log_g = s.log_g - size * back * top * np.exp(-(((way - 0.5 * below) / width) ** 2))


@_form("self_heating", tau_s=(20.0, 150.0), sign=(-1.0, 1.0))
def constant_voltage(s: Signals, size: float, rng: Rng, tau_s: float, sign: float) -> None:
    """U^2 G heats one mass from cold; ln G follows its temperature."""
    heat = kernels.follow(np.exp(np.minimum(s.log_g, 3.0)), s.step_s, tau_s, tau_s, 0.0)
    s.log_g = s.log_g + (1.0 if sign > 0 else -1.0) * size * heat


@_form("self_heating", tau_s=(3.0, 12.0), mass=(10.0, 30.0), share=(0.3, 0.7))
def constant_current(s: Signals, size: float, rng: Rng, tau_s: float, mass: float, share: float) -> None:
    """I^2 / G heats the yarn, and the yarn the fabric."""
    power = np.exp(-s.log_g - 1.0)
    yarn = kernels.follow(power, s.step_s, tau_s, tau_s, 0.0)
    fabric = kernels.follow(power, s.step_s, tau_s * mass, tau_s * mass, 0.0)
    s.log_g = s.log_g - size * (share * yarn + (1.0 - share) * fabric)


@_form("temperature_drift", sign=(-1.0, 1.0))
def wandering_room(s: Signals, size: float, rng: Rng, sign: float) -> None:
    """Follows the room, whatever it does."""
    s.log_g = s.log_g + (1.0 if sign > 0 else -1.0) * size * s.room


@_form("temperature_drift", period_s=(150.0, 600.0), uneven=(0.0, 0.4))
def room_control(s: Signals, size: float, rng: Rng, period_s: float, uneven: float) -> None:
    """The room's heating goes on and off."""
    angle = 2 * np.pi * (s.time_s / period_s + rng.uniform())
    s.log_g = s.log_g + size * np.sin(angle + uneven * np.sin(angle))


@_form("temperature_drift", settle_s=(40.0, 300.0))
def opened_window(s: Signals, size: float, rng: Rng, settle_s: float) -> None:
    """Something changes at one moment, and the room settles at another temperature."""
    since = s.share_of_time - rng.uniform(0.2, 0.6)
    s.log_g = s.log_g - size * (1.0 - np.exp(-np.maximum(since, 0.0) * s.time_s[-1] / settle_s))
