"""From contact force to conductance."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter


def positive_part(x: FloatArray, softness: float) -> FloatArray:
    """Smooth max(x, 0): contacts never press with less than nothing. Equal to x within softness^2 / x for large x."""
    larger = 0.5 * (np.abs(x) + np.sqrt(x * x + 4 * softness * softness))
    return np.where(x >= 0, larger, softness * softness / larger)  # no cancellation far below zero


class Contact(Effect):
    """Holm's contact resistance of many yarn contacts, with a path beside and a path in series.

    R_c = rho/2 sqrt(pi H / (n P)) = contact_resistance / (P / 1 N)^exponent,   G = parallel + 1 / (series + R_c)

    P = preload + contact force. `contact_resistance` gathers resistivity rho, hardness H and number n of contacts.
    The exponent is 1/2 for plastic spots, 1/3 for elastic ones, larger where their number grows as the loops close.

    Source: Holm, Electric Contacts (1967); that contacts rule the first stretch of weft-knitted sensors: J. Eng.
    Fibers Fabr. 15 (2020), doi:10.1177/1558925020969475.
    Valid: conductance rises with stretch.
    """

    name = "contact"
    in_base = True
    stage = Stage.CONTACT
    reads, writes = ("contact_force_N",), ("conductance_S",)
    pointwise = ("contact_force_N",)
    look = "conductance rises with force, fast at first"

    contact_resistance_ohm: float = parameter(4e5, unit="ohm", low=1e-3, high=1e10, scale="log", doc="at 1 N")
    parallel_S: float = parameter(1e-7, unit="S", low=1e-12, high=1e2, scale="log", doc="path that needs no contact")
    series_ohm: float = parameter(1e4, unit="ohm", low=1e-4, high=1e9, scale="log", doc="yarn and leads in series")
    preload_N: float = parameter(0.2, unit="N", low=1e-3, high=100, scale="log", doc="contact force at rest")
    exponent: float = parameter(0.5, unit="1", low=0.2, high=1.2, scale="log", doc="growth of contacts with force")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        pressing_N = positive_part(self.preload_N + signals["contact_force_N"], 0.1 * self.preload_N)
        # The power is made by its logarithm, which is quicker.
        contact_ohm = self.contact_resistance_ohm * np.exp(-self.exponent * np.log(pressing_N))
        return {"conductance_S": self.parallel_S + 1.0 / (self.series_ohm + contact_ohm)}
