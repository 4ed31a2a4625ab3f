"""Sensors whose resistance rises with stretch: carbon-filled and silver-coated composites, straightened yarn.

The laws take the place of `contact` in a model: they need no force, and make the conductance from the strain.
"""

from __future__ import annotations

import numpy as np

from testbench.knit.additive import ConductanceLaw
from testbench.knit.conduction.contact import positive_part
from testbench.knit.effect import Effect, FloatArray, Points, Signals, Stage, parameter

CAP = 60.0  # e^60 is beyond all resistances; it keeps a wild fit finite


class PiezoresistiveLaw(Effect):
    """Base of the laws that make the conductance from the strain, in the place of contacts."""

    mechanism = "piezoresistance"
    in_base = True
    stage = Stage.CONTACT
    reads, writes = ("strain",), ("conductance_S",)

    rest_ohm: float = parameter(1e5, unit="ohm", low=1e-3, high=1e12, scale="log", doc="resistance at zero strain")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        """Resistance at rest, from the measured conductance at the smallest strains."""
        if "conductance_S" not in signals:
            return []
        conductance = signals["conductance_S"] * np.exp(residual.get("conductance", 0.0))
        low = signals["strain"] <= np.quantile(signals["strain"], 0.05)
        return [{"rest_ohm": float(1 / np.median(conductance[low]))}]


class Piezoresistance(PiezoresistiveLaw):
    """Resistance rises exponentially with strain, with a bend.

    ln R = ln rest + gauge * e + bend * e^2

    For small strains gauge is the gauge factor dR / (R de).

    Source: Taylor expansion of ln R; linear term as in Knite et al., Sens. Actuators A 110 (2004) 142
    (polyisoprene - carbon black).
    Valid: conductance falls with stretch (gauge > 0); negative gauge: rises.
    """

    name = "piezoresistance"
    look = "conductance falls with stretch, the same percentage for each further percent"

    gauge: float = parameter(3.0, unit="1", low=-50, high=200, doc="gauge factor at zero strain")
    bend: float = parameter(0.0, unit="1", low=-200, high=500, doc="curvature of ln R over strain")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        e = signals["strain"]
        log_ratio = np.clip(self.gauge * e + self.bend * e * e, -CAP, CAP)
        return {"conductance_S": np.exp(-log_ratio) / self.rest_ohm}


class YarnElongation(ConductanceLaw):
    """Once the loops are straight the conductive yarn itself is stretched: its resistance rises.

    ln G -= gauge * s,   s = ((e - onset) + sqrt((e - onset)^2 + 4 width^2)) / 2 minus its value at e = 0

    Source: J. Eng. Fibers Fabr. 15 (2020), doi:10.1177/1558925020969475 (contacts rule the first stretch of
    weft-knitted sensors, the length of the yarn the later one).
    Valid: conductance rises first and bends down at high strain.
    """

    name = "yarn_elongation"
    bends_a_law = True
    strength = "gauge"
    look = "conductance turns round and falls again at high strain, force does not"

    gauge: float = parameter(1.0, unit="1", low=0, high=300, doc="gauge factor of the straightened yarn")
    onset: float = parameter(0.2, unit="1", low=0.01, high=2, scale="log", doc="strain where the loops are straight")
    width: float = parameter(0.02, unit="1", low=1e-3, high=0.3, scale="log", doc="strain over which it sets in")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        rest = positive_part(np.array([-self.onset]), self.width)
        stretched = positive_part(signals["strain"] - self.onset, self.width) - rest
        return -self.gauge * stretched


class YarnElongationPower(ConductanceLaw):
    """As `yarn_elongation`, but its loops get straight one after the other: the resistance rises with a power.

    ln G -= gauge * (e - onset)+ * ((e - onset)+ / span)^(power - 1)

    Source: as `yarn_elongation`, with more and more of the yarn stretched.
    Valid: conductance rises first and bends down at high strain; `span` is the largest strain of the recording.
    """

    name = "yarn_elongation_power"
    mechanism = "yarn_elongation"
    bends_a_law = True
    strength = "gauge"
    look = "conductance turns round and falls ever more steeply at high strain, force does not"

    gauge: float = parameter(1.0, unit="1", low=0, high=300, doc="gauge factor a `span` beyond the onset")
    onset: float = parameter(0.2, unit="1", low=0.01, high=2, scale="log", doc="where the first loop is straight")
    power: float = parameter(1.5, unit="1", low=1, high=4, doc="1: all loops at once")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="excess of strain at which gauge holds")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        excess = np.maximum(signals["strain"] - self.onset, 0.0)
        return -self.gauge * self.span * (excess / self.span) ** self.power


class PiezoresistanceTunnelling(PiezoresistiveLaw):
    """Electrons tunnel between filler particles whose gaps widen in proportion to the strain.

    R = rest * (1 + e) * exp(barrier * e)

    Source: Simmons, J. Appl. Phys. 34 (1963) 1793 (tunnelling); Zhang et al., J. Polym. Sci. B 38 (2000) 2739
    (gap in proportion to strain).
    Valid: filled well above the percolation threshold; barrier = gap at rest times 2 sqrt(2 m phi) / hbar.
    """

    name = "piezoresistance_tunnelling"
    look = "conductance falls exponentially with stretch"

    barrier: float = parameter(3.0, unit="1", low=0, high=200, doc="gap at rest over the tunnelling length")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        e = np.maximum(signals["strain"], -0.9)
        log_ratio = np.clip(np.log1p(e) + self.barrier * e, -CAP, CAP)
        return {"conductance_S": np.exp(-log_ratio) / self.rest_ohm}


class PiezoresistancePercolation(PiezoresistiveLaw):
    """Stretching dilutes the filler towards the percolation threshold.

    G = (1 / rest) * ((1 - e / limit)+)^exponent + leak

    Source: Kirkpatrick, Rev. Mod. Phys. 45 (1973) 574 (conductivity goes as (p - p_c)^t), p falling linearly with e.
    Valid: e below the limit where the network breaks; t about 2 in three dimensions, 1.3 in two.
    """

    name = "piezoresistance_percolation"
    look = "conductance falls faster and faster and is nearly gone at a certain stretch"

    limit: float = parameter(0.8, unit="1", low=0.05, high=20, scale="log", doc="strain where the network breaks")
    exponent: float = parameter(2.0, unit="1", low=0.5, high=5, doc="critical exponent of the conductivity")
    leak_S: float = parameter(1e-9, unit="S", low=1e-15, high=1, scale="log", doc="conductance that remains")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        left = np.maximum(1 - signals["strain"] / self.limit, 0.0)
        return {"conductance_S": left**self.exponent / self.rest_ohm + self.leak_S}
