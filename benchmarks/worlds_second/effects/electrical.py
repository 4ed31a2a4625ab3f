"""Effects of conductance alone: wear, cracks, stretched yarn, overshoot, rate and the peak on the way back."""

from __future__ import annotations

import numpy as np

from worlds_second.chain import Signals
from worlds_second.draws import lin, log, pick
from worlds_second.effects.kinematics import above, highest
from worlds_second.effects.mechanics import SMALLEST_SWING
from worlds_second.effects.registry import form
from worlds_second.kernels import Array, bouc_wen, lag, turns

AT = "electrical"
SIGN = pick(-1.0, 1.0)


@form("coating_wear", AT, 10.0)
def rubbed_off(s: Signals, m: float) -> Array:
    """Each stroke rubs off the same share of the coating."""
    return s.ln_g + np.log1p(-np.minimum(m * 1e-2 * s.travel, 0.99))


@form("coating_wear", AT, 2.0, strokes=log(10.0, 150.0))
def running_in(s: Signals, m: float, strokes: float) -> Array:
    """The first strokes wear most."""
    return s.ln_g - m * np.log1p(s.travel / strokes)


@form("coating_wear", AT, 10.0, power=lin(1.0, 2.5))
def rubbed_under_load(s: Signals, m: float, power: float) -> Array:
    """Wear is load times path (Archard 1953)."""
    path = np.abs(np.diff(s.e, prepend=s.e[0]))
    return s.ln_g - m * 1e-2 * np.cumsum(path * np.maximum(s.f, 0.0) ** power)


@form("coating_cracks", AT, 2.0, edge=lin(0.1, 0.45), power=lin(0.8, 1.8))
def crack_density(s: Signals, m: float, edge: float, power: float) -> Array:
    """Cracks multiply above an edge of the largest stretch, for good."""
    return s.ln_g - m * above(highest(s), edge) ** power


@form("coating_cracks", AT, 1.0, first=lin(0.2, 0.45), gap=lin(0.05, 0.15))
def crack_by_crack(s: Signals, m: float, first: float, gap: float) -> Array:
    """Islands break off one by one, each at its stretch."""
    return s.ln_g - m * np.maximum(np.floor((highest(s) - first) / gap) + 1.0, 0.0)


@form("coating_cracks", AT, 5.0, edge=lin(0.0, 0.3), opening=lin(0.2, 1.0))
def cracks_that_gape(s: Signals, m: float, edge: float, opening: float) -> Array:
    """Cracks are for good; part of their resistance opens and closes with the strain."""
    return s.ln_g - np.log1p(m * above(highest(s), edge) * (1.0 - opening + opening * s.e))


@form("yarn_elongation", AT, 200.0, edge=lin(0.45, 0.7), power=lin(1.0, 2.0))
def taut_yarn(s: Signals, m: float, edge: float, power: float) -> Array:
    """Where the loops are drawn straight the yarn itself stretches."""
    return s.ln_g - m * above(s.e, edge) ** power


@form("yarn_elongation", AT, 50.0, sharp=lin(6.0, 14.0))
def thinning(s: Signals, m: float, sharp: float) -> Array:
    """The yarn's resistance rises ever more steeply."""
    return s.ln_g - np.log1p(m * (s.e / 1.05) ** sharp)


@form("yarn_elongation", AT, 20.0, edge=lin(0.5, 0.7), width=lin(0.02, 0.06))
def kinked(s: Signals, m: float, edge: float, width: float) -> Array:
    """Past a rounded kink each percent of strain costs the same."""
    return s.ln_g - m * width * np.logaddexp(0.0, (s.e - edge) / width)


@form("electrical_overshoot", AT, 3.0, time_s=log(1.0, 10.0), sign=SIGN)
def after_strain(s: Signals, m: float, time_s: float, sign: float) -> Array:
    """A share of the change of strain shows at once and fades."""
    return s.ln_g + sign * m * (s.e - lag(s.e, s.dt, time_s))


@form("electrical_overshoot", AT, 3.0, time_s=log(1.0, 10.0))
def after_conductance(s: Signals, m: float, time_s: float) -> Array:
    """Each change of conductance goes too far and comes back."""
    return s.ln_g + m * (s.ln_g - lag(s.ln_g, s.dt, time_s))


@form("electrical_overshoot", AT, 3.0, time_s=log(1.0, 8.0), knee=log(0.3, 2.0), sign=SIGN)
def stirred(s: Signals, m: float, time_s: float, knee: float, sign: float) -> Array:
    """Motion of either direction stirs the contacts, which settle afterwards."""
    return s.ln_g + sign * m * lag(np.tanh(np.abs(s.rate) / knee), s.dt, time_s, start=0.0)


@form("rate_resistance", AT, 3.0, power=lin(0.4, 1.3), sign=SIGN)
def signed_rate(s: Signals, m: float, power: float, sign: float) -> Array:
    """A shift with the sign of the rate, a power of it."""
    return s.ln_g + sign * m * np.sign(s.rate) * np.abs(s.rate) ** power


@form("rate_resistance", AT, 3.0, knee=log(0.1, 1.5), sign=SIGN)
def either_way(s: Signals, m: float, knee: float, sign: float) -> Array:
    """The same shift in both directions, that levels off."""
    return s.ln_g + sign * m * np.abs(s.rate) / (np.abs(s.rate) + knee)


@form("rate_resistance", AT, 3.0, share=lin(0.2, 0.8), knee=log(0.2, 1.0), sign=SIGN)
def more_on_the_way_out(s: Signals, m: float, share: float, knee: float, sign: float) -> Array:
    """A shift in both directions, the smaller on the way back."""
    shift = np.tanh(s.rate / knee)
    return s.ln_g + sign * m * np.where(shift > 0, shift, -share * shift)


def _way_back(s: Signals, reach: float) -> Array:
    """0 on the way out, 1 on the way back, over a short travel between them."""
    return np.clip(-bouc_wen(s.e, 1.0, reach, 0.6), 0.0, 1.0)


@form("shoulder_peak", AT, 2.0, centre=lin(0.3, 0.65), width=lin(0.05, 0.13), reach=log(0.03, 0.1))
def bump(s: Signals, m: float, centre: float, width: float, reach: float) -> Array:
    """Loops part at one strain on the way back."""
    return s.ln_g - m * _way_back(s, reach) * np.exp(-0.5 * ((s.e - centre) / width) ** 2)


@form("shoulder_peak", AT, 2.0, share=lin(0.45, 0.75), width=lin(0.06, 0.13), reach=log(0.03, 0.1))
def bump_after_turn(s: Signals, m: float, share: float, width: float, reach: float) -> Array:
    """Loops part at a share of the last largest stretch."""
    top = turns(s.e, SMALLEST_SWING)[1]
    return s.ln_g - m * top * _way_back(s, reach) * np.exp(-0.5 * ((s.e - share * top) / width) ** 2)


@form("shoulder_peak", AT, 2.0, low=lin(0.2, 0.4), span=lin(0.15, 0.3), steep=log(15.0, 50.0), reach=log(0.03, 0.1))
def window(s: Signals, m: float, low: float, span: float, steep: float, reach: float) -> Array:
    """Between two strains the contacts are open on the way back."""
    gate = 0.5 * (np.tanh(steep * (s.e - low)) - np.tanh(steep * (s.e - low - span)))
    return s.ln_g - m * _way_back(s, reach) * gate
