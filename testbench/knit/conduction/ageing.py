"""Contacts that every turn of the motion renews, and that age until the next."""

from __future__ import annotations

import numpy as np

from testbench.knit.conduction.contact_relaxation import SpotsLaw
from testbench.knit.conduction.turning import since_turn_s
from testbench.knit.effect import FloatArray, Points, Signals, parameter


class ContactAgeing(SpotsLaw):
    """A turn of the motion makes the contacts anew; from then on they grow with the logarithm of time.

    ln G += gain * ln(1 + t / tau),   t = time since the last turn; before the first since the start

    Source: Rabinowicz, Proc. Phys. Soc. 71 (1958) 668; Dieterich, J. Geophys. Res. 77 (1972) 3690 (contacts at rest
    strengthen with the logarithm of time).
    Valid: contacts that stick between turns; a turn counts once the knit has come back by `back`.
    """

    name = "contact_ageing"
    jumps = ("back",)
    look = "conductance falls at each turn of the motion and creeps up until the next, fast at first"

    gain: float = parameter(0.05, unit="1", low=-2, high=2, doc="change of ln G per e-fold of time")
    tau_s: float = parameter(1.0, unit="s", low=0.05, high=100, scale="log", doc="when the growth sets in")
    back: float = parameter(0.01, unit="1", low=5e-4, high=0.2, scale="log", doc="strain that makes a turn")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        age_s, _, _ = since_turn_s(np.ascontiguousarray(signals["strain"]), self.back, dt_s)
        return self.gain * np.log1p(age_s / self.tau_s)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        # No gradient leads from one number of turns to another.
        return [{"back": back, "tau_s": tau_s} for back in (0.002, 0.005, 0.01, 0.02) for tau_s in (0.3, 2.0)]
