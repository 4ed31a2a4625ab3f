"""Contacts relax, part or creep: conductance goes on changing while strain and force hold."""

from __future__ import annotations

import numpy as np

from testbench.knit.additive import ConductanceLaw
from testbench.knit.effect import Effect, FloatArray, Points, Signals, Stage, Vector, parameter
from testbench.knit.filters import (
    activated_memory,
    highpass,
    log_conductance,
    lowpass,
    memory,
    memory_of_box,
    memory_of_decades,
)

SPOTS_S = (3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)  # quicker is an overshoot


def _share_lost(of: str) -> float:
    return parameter(0.3, unit="1", low=-3, high=0.95, doc=f"share of {of} that is lost; below 0: that is gained")


class ContactRelaxationLaw(Effect):
    """Base of the laws of a pressing force that changes while the knit's force holds."""

    mechanism = "contact_relaxation"
    stage = Stage.PRESSURE
    reads, writes = ("contact_force_N",), ("contact_force_N",)
    strength = "fraction"

    def gained_N(self, pressing_N: FloatArray, dt_s: float) -> FloatArray:
        """What is added to a pressing force that would stay, shape (n,)."""
        raise NotImplementedError

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        pressing_N = signals["contact_force_N"]
        return {"contact_force_N": pressing_N + self.gained_N(pressing_N, dt_s)}


class ContactRelaxation(ContactRelaxationLaw):
    """The yarns yield where they touch: the pressing force fades although the knit's force holds.

    P(t) = P_0(t) - fraction * integral of (1 - exp(-(t - s) / tau)) dP_0(s)

    With a negative fraction the contacts bed in instead, and seem pressed the harder the longer.

    Source: Holm, Electric Contacts (1967) (stress relaxation of contacts); Prony form as `stress_relaxation`.
    Valid: small changes of the contact geometry.
    """

    name = "contact_relaxation"
    look = "in a hold the conductance sinks while the force does not"

    fraction: float = _share_lost("the contact force")
    # Quicker than this it is an overshoot.
    tau_s: float = parameter(20.0, unit="s", low=1, high=3000, scale="log", doc="time in which 63 % of it is lost")

    def gained_N(self, pressing_N: FloatArray, dt_s: float) -> FloatArray:
        return -self.fraction * (lowpass(pressing_N, self.tau_s, dt_s) - pressing_N[0])


class ContactRelaxationSpectrum(ContactRelaxationLaw):
    """The pressing force fades over decades of time.

    P(t) = P_0(t) - fraction * integral of phi(t - s) dP_0(s)
    phi(t) = mean of 1 - exp(-t / tau) over ln(tau) from `shortest_s` to `longest_s`, if that is longer

    Source: Fung, Biomechanics (1993), section 7.6 (box spectrum).
    Valid: as `contact_relaxation`.
    """

    name = "contact_relaxation_spectrum"
    look = "in a hold the conductance sinks ever more slowly while the force does not"

    fraction: float = _share_lost("the contact force")
    shortest_s: float = parameter(1.0, unit="s", low=0.05, high=100, scale="log", doc="shortest relaxation time")
    longest_s: float = parameter(100.0, unit="s", low=1, high=1e5, scale="log", doc="longest relaxation time")

    def gained_N(self, pressing_N: FloatArray, dt_s: float) -> FloatArray:
        return -memory_of_box(pressing_N, self.fraction, self.shortest_s, self.longest_s, dt_s)


class ContactRelaxationProny(ContactRelaxationLaw):
    """The pressing force fades, or grows, with any spectrum of relaxation times.

    P(t) = P_0(t) - sum_k w_k * integral of (1 - exp(-(t - s) / tau_k)) dP_0(s),   tau_k = 3, 10, ... 1000 s

    Source: Tschoegl, The Phenomenological Theory of Linear Viscoelastic Behavior (1989), ch. 3 (Prony series at fixed
    times).
    Valid: as `contact_relaxation`.
    """

    name = "contact_relaxation_prony"
    strength = "fractions"
    look = "in a hold the conductance changes over whatever times while the force does not"

    fractions: Vector = parameter(
        (0.0,) * len(SPOTS_S), unit="1", low=-3, high=1, doc="share of the contact force that is lost at each time"
    )

    def gained_N(self, pressing_N: FloatArray, dt_s: float) -> FloatArray:
        return -memory(pressing_N, np.array(SPOTS_S), np.array(self.fractions), dt_s)


class SpotsLaw(ConductanceLaw):
    """Base of the laws of contact spots that part, grow or age under a pressing force that stays."""

    mechanism = "contact_relaxation"


class ContactRelaxationAsymmetric(SpotsLaw):
    """Contacts close quickly under load and part slowly when it goes.

    ln G += gain_per_N * (y - P),   tau y' = P - y,   tau = tau_up where y rises, tau_down where it falls

    Source: adhesion of contact spots on unloading, Johnson, Kendall & Roberts, Proc. R. Soc. A 324 (1971) 301; two
    time constants as the simplest law.
    Valid: small changes; tau_down above tau_up.
    """

    name = "contact_relaxation_asymmetric"
    reads = ("contact_force_N", "conductance_S")
    strength = "gain_per_N"
    look = "conductance follows a pull at once and lags behind a release"

    gain_per_N: float = parameter(0.1, unit="1/N", low=0, high=5, doc="change of ln G per newton of lag")
    tau_up_s: float = parameter(1.0, unit="s", low=0.05, high=30, scale="log", doc="time in which contacts close")
    tau_down_s: float = parameter(30.0, unit="s", low=1, high=1000, scale="log", doc="time in which contacts part")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        from testbench.knit.memories import two_way_lag

        pressing_N = signals["contact_force_N"]
        return self.gain_per_N * (two_way_lag(pressing_N, self.tau_up_s, self.tau_down_s, dt_s) - pressing_N)


class ContactRelaxationSpots(SpotsLaw):
    """Contact spots part again after each change: part of what the conductance gained fades over decades of time.

    ln G(t) = ln G_0(t) - fraction * integral of phi(t - s) d(ln G_0)(s)
    phi(t) = mean of 1 - exp(-t / tau) over ln(tau) from `shortest_s` to `longest_s`, if that is longer

    Source: Fung, Biomechanics (1993), section 7.6 (box spectrum), for the number of spots that conduct.
    Valid: small changes; times longer than those of an overshoot.
    """

    name = "contact_relaxation_spots"
    reads = ("conductance_S",)
    strength = "fraction"
    look = "after every move part of the change of conductance comes back over seconds to minutes"

    fraction: float = _share_lost("the change of ln G")
    shortest_s: float = parameter(6.0, unit="s", low=3, high=100, scale="log", doc="shortest relaxation time")
    longest_s: float = parameter(300.0, unit="s", low=30, high=1e5, scale="log", doc="longest relaxation time")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        log_g = log_conductance(signals["conductance_S"])
        return -memory_of_box(log_g, self.fraction, self.shortest_s, self.longest_s, dt_s)


class ContactRelaxationActivated(SpotsLaw):
    """Contact spots part the sooner, the more the knit is stretched.

    ln G(t) = ln G_0(t) - fraction * y,   tau(e) y' = ln G_0 - y,   tau(e) = tau exp(-activation e / span)

    Source: Eyring, J. Chem. Phys. 4 (1936) 283 (a load lowers the barrier, and the time falls exponentially).
    Valid: one time at each stretch; `span` is the largest strain of the recording.
    """

    name = "contact_relaxation_activated"
    strength = "fraction"
    look = "after every move part of the change of conductance comes back, quickly where the knit is stretched"

    fraction: float = _share_lost("the change of ln G")
    tau_s: float = parameter(60.0, unit="s", low=3, high=3000, scale="log", doc="relaxation time without stretch")
    activation: float = parameter(1.0, unit="1", low=0, high=5, doc="e-folds by which it is shorter at `span`")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="largest strain")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        log_g, load = log_conductance(signals["conductance_S"]), signals["strain"] / self.span
        return -self.fraction * activated_memory(log_g, load, self.tau_s, self.activation, dt_s)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return [{"tau_s": tau_s, "activation": a} for tau_s in (15.0, 50.0, 150.0) for a in (0.7, 2.0)]


class ContactCreep(ContactRelaxationLaw):
    """Contact spots creep and grow under constant load: the pressing force seems to rise with time.

    P(t) = P_0(t) + per_decade * integral of log10(1 + (t - s) / tau) dP_0(s)

    Source: Holm, Electric Contacts (1967) (creep of the softened asperities).
    Valid: the opposite of `contact_relaxation`; both may be there at different times.
    """

    name = "contact_creep"
    strength = "per_decade"
    look = "in a hold the conductance rises while the force does not"

    per_decade: float = parameter(0.05, unit="1", low=0, high=0.5, doc="relative gain per decade of time")
    tau_s: float = parameter(1.0, unit="s", low=0.05, high=300, scale="log", doc="when the creep sets in")

    def gained_N(self, pressing_N: FloatArray, dt_s: float) -> FloatArray:
        return memory_of_decades(pressing_N, self.per_decade, self.tau_s, dt_s)


class ElectricalOvershootForce(SpotsLaw):
    """The conductance overshoots with sudden changes of the contact force.

    ln G += gain_per_N * (P - y),   tau y' = P - y

    Source: as `electrical_overshoot`, driven by the pressing force.
    Valid: small overshoot.
    """

    name = "electrical_overshoot_force"
    # What relaxes is the contact under its force, hence the mechanism.
    reads = ("contact_force_N", "conductance_S")
    strength = "gain_per_N"
    look = "conductance shoots beyond its final value, most where the knit is stiff"

    gain_per_N: float = parameter(0.1, unit="1/N", low=-5, high=5, doc="change of ln G per newton of sudden force")
    tau_s: float = parameter(15.0, unit="s", low=5, high=300, scale="log", doc="time in which it settles")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.gain_per_N * highpass(signals["contact_force_N"], self.tau_s, dt_s)
