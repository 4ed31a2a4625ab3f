"""Contacts that any motion breaks and rest heals: the conductance shifts with the distance moved, and comes back."""

from __future__ import annotations

import numpy as np

from testbench.knit.conduction.transient import OvershootLaw
from testbench.knit.effect import FloatArray, Signals, Vector, parameter, step_s, zeros
from testbench.knit.filters import lagging_rate, lowpass

HEALING_S = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0)


def shaken(speed: FloatArray, tau_s: float, dt_s: float) -> FloatArray:
    """What is left of the distance travelled where it heals within `tau_s`: y' = speed - y / tau, shape (n,)."""
    return tau_s * lowpass(speed, tau_s, dt_s)


class ElectricalOvershootMagnitude(OvershootLaw):
    """Any motion, in either direction, shakes the contacts: the conductance shifts and comes back at rest.

    ln G += gain * y,   y' = |e'| - y / tau        (e' with a lag of 0.1 s)

    Source: a network of filler that motion breaks and rest heals, Kraus, J. Appl. Polym. Sci. Appl. Polym. Symp. 39
    (1984) 75, linearised; of its conductance: Yamaguchi, Busfield & Thomas, J. Polym. Sci. B 41 (2003) 2079.
    Valid: small shift.
    """

    name = "electrical_overshoot_magnitude"
    look = "conductance shifts the same way during stretch and release and comes back in a hold"

    gain: float = parameter(0.5, unit="1", low=-20, high=20, doc="change of ln G per unit of strain path")
    tau_s: float = parameter(3.0, unit="s", low=0.1, high=300, scale="log", doc="time in which it heals")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.gain * shaken(self.speed(lagging_rate(signals["strain"], dt_s)), self.tau_s, dt_s)

    def speed(self, rate: FloatArray) -> FloatArray:
        """How fast the contacts are shaken at these strain rates, shape (n,)."""
        return np.abs(rate)


class ElectricalOvershootTwoWays(ElectricalOvershootMagnitude):
    """Motion shakes the contacts, on the way back by another share than on the way out; they come back at rest.

    ln G += gain * y,   y' = h |e'| - y / tau,   h = 1 on the way out, back on the way back
    (e' with a lag of 0.1 s)

    Source: as `electrical_overshoot_magnitude`; that particles part and meet otherwise on the way back: Flandin,
    Hiltner & Baer, Polymer 42 (2001) 827.
    Valid: small shift.
    """

    name = "electrical_overshoot_two_ways"
    look = "conductance shifts the same way during stretch and release, more in one of them, and comes back in a hold"

    back: float = parameter(1.5, unit="1", low=-5, high=5, doc="share of it on the way back")

    def speed(self, rate: FloatArray) -> FloatArray:
        return np.where(rate > 0, rate, -self.back * rate)


class ElectricalOvershootTwoWaysProny(OvershootLaw):
    """Motion shakes the contacts, out and back as may be, and they come back over any spectrum of times.

    ln G += sum_k (u_k y_k + v_k z_k) / span,   y_k' = (e')+ - y_k / tau_k,   z_k' = (-e')+ - z_k / tau_k

    tau_k = 0.3, 1, ... 100 s; `weights` are u, then v. With v = -u it is a high-pass of the strain, with v = u any
    motion shifts it the same way.

    Source: as `electrical_overshoot_two_ways`, with a Prony series at fixed times (Tschoegl, 1989, ch. 3).
    Valid: small shift.
    """

    name = "electrical_overshoot_two_ways_prony"
    strength = "weights"
    look = "conductance shifts while it moves, by more in one direction, and comes back over whatever times"

    weights: Vector = zeros(2 * len(HEALING_S), unit="1", most=5, doc="change of ln G by a sudden strain of `span`")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain by which it is counted")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return np.asarray(self.weights) @ self._shaken(signals, dt_s)

    def terms(self, parameter: str, signals: Signals) -> FloatArray:
        return self._shaken(signals, step_s(signals))

    def _shaken(self, signals: Signals, dt_s: float) -> FloatArray:
        """Way out and way back that each time remembers, over `span`, shape (2 k, n)."""
        rate = lagging_rate(signals["strain"], dt_s) / self.span
        ways = np.maximum(rate, 0.0), np.maximum(-rate, 0.0)
        return np.stack([shaken(way, tau_s, dt_s) for way in ways for tau_s in HEALING_S])
