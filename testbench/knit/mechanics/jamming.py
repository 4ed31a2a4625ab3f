"""Jamming: at large strain the loops lock, and the force climbs steeply."""

from __future__ import annotations

import numpy as np

from testbench.knit.additive import ForceLaw
from testbench.knit.effect import FloatArray, Points, Signals, parameter


class JammingLaw(ForceLaw):
    """Base of the laws of jamming: force added where the loops are drawn straight."""

    mechanism = "jamming_stiffening"
    strength = "stiffness_N"
    bends_a_law = True


class JammingStiffening(JammingLaw):
    """Beyond an onset the loops are drawn straight and jam: an extra stiffness sets in.

    F += stiffness * ((e - onset)+)^2 / (2 width)        until e - onset = width, then with constant slope

    Source: Postle, Carnaby & de Jong, The Mechanics of Wool Structures (1988) (jammed state of knitted loops);
    the smooth ramp of stiffness is ours.
    Valid: loading beyond the loop-straightening range.
    """

    name = "jamming_stiffening"
    look = "above a certain strain the force suddenly rises much faster"

    stiffness_N: float = parameter(20.0, unit="N", low=0, high=1e4, doc="extra force per unit strain when jammed")
    onset: float = parameter(0.25, unit="1", low=0.02, high=2, scale="log", doc="strain where the loops jam")
    width: float = parameter(0.02, unit="1", low=1e-3, high=0.3, scale="log", doc="strain over which they do")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        beyond = np.maximum(signals["strain"] - self.onset, 0.0)
        within = np.minimum(beyond, self.width)
        return self.stiffness_N * (beyond - within + within**2 / (2 * self.width))

    def starts(self, signals: Signals, residual: Signals) -> Points:
        top = float(np.max(signals["strain"]))
        onsets = [share * top for share in (0.35, 0.5, 0.62, 0.72, 0.82, 0.9)]
        return [{"onset": onset, "width": width} for onset in onsets for width in (0.02, 0.3)]


class JammingStiffeningPower(JammingLaw):
    """Loops jam little by little: an extra force with a high power of strain.

    F += force * (e+ / 0.3)^exponent

    Source: engineering use (power-law fit of the locking branch).
    Valid: below the strain of rupture.
    """

    name = "jamming_stiffening_power"
    strength = "force_at_30_percent_N"
    look = "the last third of the stretch is much stiffer than the first two"

    force_at_30_percent_N: float = parameter(0.5, unit="N", low=0, high=1e3, doc="extra force at 30 % strain")
    exponent: float = parameter(6.0, unit="1", low=3, high=20, scale="log", doc="how suddenly it comes")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        relative = np.maximum(signals["strain"], 0.0) / 0.3
        return self.force_at_30_percent_N * relative**self.exponent


class JammingStiffeningLocking(JammingLaw):
    """Loops that lock: the force rises without bound towards a locking strain.

    F += force * e^2 / (limit * (limit - e))

    Source: finite extensibility, after Gent, Rubber Chem. Technol. 69 (1996) 59, written for strain.
    Valid: below the locking strain; the last per cent before it is cut off.
    """

    name = "jamming_stiffening_locking"
    strength = "force_N"
    look = "force rises ever more steeply towards one strain"

    force_N: float = parameter(0.5, unit="N", low=0, high=1e3, doc="twice the force at half the locking strain")
    limit: float = parameter(0.5, unit="1", low=0.05, high=5, scale="log", doc="locking strain")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        e = np.clip(signals["strain"] / self.limit, 0.0, 0.99)
        return self.force_N * e * e / (1 - e)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        top = float(np.max(signals["strain"]))
        return [{"limit": share * top} for share in (1.03, 1.1, 1.25, 1.5, 2.0) if share * top > 0.05]
