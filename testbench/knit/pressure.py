"""Force that presses the contacts: it may relax, saturate and stick apart from the force that is measured."""

from __future__ import annotations

from typing import Any

import numpy as np

from testbench.knit import spectra
from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter
from testbench.knit.filters import lowpass, memory, shifted
from testbench.knit.hysteresis import mean_slip


class ContactDrive(Effect):
    """What the contacts feel: the force, the strain, or some of both.

    P = (1 - strain_share) * P_0 + strain_share * (low + span_N * e / span)

    Loops that are turned and shifted make and break contacts by geometry, whatever force it takes: such sensors know
    nothing of what the force does at the same strain. `low` and the spans put strain on the scale of the force; the
    contact law does the rest.

    Source: Holm, Electric Contacts (1967) for the force; contact by geometry: Atalay, Kennon & Husain, Sensors 13
    (2013) 11114, doi:10.3390/s130811114.
    Valid: conductance that rises with stretch.
    """

    name = "contact_drive"
    stage = Stage.PRESSURE
    reads, writes = ("strain", "contact_force_N"), ("contact_force_N",)
    look = "the conductance does not follow the loops and the relaxation that the force shows"

    strain_share: float = parameter(0.0, unit="1", low=0, high=1, doc="0: force alone, 1: strain alone")
    low_N: float = parameter(0.0, unit="N", low=-1e3, high=1e3, doc="force that stands for zero strain")
    span_N: float = parameter(3.0, unit="N", low=1e-3, high=1e4, doc="rise of force that stands for the whole span")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain at the end of the span")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        by_strain_N = self.low_N + self.span_N * signals["strain"] / self.span
        felt_N = signals["contact_force_N"] + self.strain_share * (by_strain_N - signals["contact_force_N"])
        return {"contact_force_N": felt_N}


class ContactRelaxation(Effect):
    """The yarns yield where they touch: the pressing force fades although the knit's force holds.

    With a negative fraction the contacts bed in instead, and seem pressed the harder the longer.

    P(t) = P_0(t) - fraction * integral of (1 - exp(-(t - s) / tau)) dP_0(s)

    Source: Holm, Electric Contacts (1967) (stress relaxation of contacts); Prony form as `stress_relaxation`.
    Valid: small changes of the contact geometry.
    """

    name = "contact_relaxation"
    stage = Stage.PRESSURE
    reads, writes = ("contact_force_N",), ("contact_force_N",)
    strength = "fraction"
    look = "in a hold the conductance sinks while the force does not"

    fraction: float = parameter(
        0.3, unit="1", low=-3, high=0.95, doc="share of the contact force that is lost; below 0: that is gained"
    )
    tau_s: float = parameter(20.0, unit="s", low=0.1, high=3000, scale="log", doc="time in which 63 % of it is lost")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        pressing_N = signals["contact_force_N"]
        lost = lowpass(pressing_N, self.tau_s, dt_s) - pressing_N[0]
        return {"contact_force_N": pressing_N - self.fraction * lost}


class ContactRelaxationSpectrum(Effect):
    """The pressing force fades over decades of time.

    P(t) = P_0(t) - fraction * integral of phi(t - s) dP_0(s)
    phi(t) = mean of 1 - exp(-t / tau) over ln(tau) from `shortest_s` to `longest_s`

    Source: Fung, Biomechanics (1993), section 7.6 (box spectrum).
    Valid: as `contact_relaxation`.
    """

    name = "contact_relaxation_spectrum"
    idea = "contact_relaxation"
    stage = Stage.PRESSURE
    reads, writes = ("contact_force_N",), ("contact_force_N",)
    strength = "fraction"
    look = "in a hold the conductance sinks ever more slowly while the force does not"

    fraction: float = parameter(
        0.3, unit="1", low=-3, high=0.95, doc="share of the contact force that is lost; below 0: that is gained"
    )
    shortest_s: float = parameter(1.0, unit="s", low=0.05, high=100, scale="log", doc="shortest relaxation time")
    longest_s: float = parameter(100.0, unit="s", low=1, high=1e5, scale="log", doc="longest relaxation time")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        times, weights = spectra.box(self.shortest_s, self.longest_s)
        lost = memory(signals["contact_force_N"], times, self.fraction * weights, dt_s)
        return {"contact_force_N": signals["contact_force_N"] - lost}


class ContactRelaxationAsymmetric(Effect):
    """Contacts close quickly under load and part slowly when it goes.

    ln G += gain_per_N * (y - P),   tau y' = P - y,   tau = tau_up where y rises, tau_down where it falls

    Source: adhesion of contact spots on unloading, Johnson, Kendall & Roberts, Proc. R. Soc. A 324 (1971) 301; two
    time constants as the simplest law.
    Valid: small changes; tau_down above tau_up.
    """

    name = "contact_relaxation_asymmetric"
    idea = "contact_relaxation"
    stage = Stage.ELECTRICAL
    reads, writes = ("contact_force_N", "conductance_S"), ("conductance_S",)
    strength = "gain_per_N"
    look = "conductance follows a pull at once and lags behind a release"

    gain_per_N: float = parameter(0.1, unit="1/N", low=0, high=5, doc="change of ln G per newton of lag")
    tau_up_s: float = parameter(1.0, unit="s", low=0.05, high=30, scale="log", doc="time in which contacts close")
    tau_down_s: float = parameter(30.0, unit="s", low=1, high=1000, scale="log", doc="time in which contacts part")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        from testbench.knit.kernels import two_way_lowpass

        pressing_N = signals["contact_force_N"]
        keep_up, keep_down = np.exp(-dt_s / self.tau_up_s), np.exp(-dt_s / self.tau_down_s)
        lag_N = two_way_lowpass(pressing_N, keep_up, keep_down) - pressing_N
        return {"conductance_S": shifted(signals["conductance_S"], self.gain_per_N * lag_N)}


class ContactCreep(Effect):
    """Contact spots creep and grow under constant load: the pressing force seems to rise with time.

    P(t) = P_0(t) + per_decade * integral of log10(1 + (t - s) / tau) dP_0(s)

    Source: Holm, Electric Contacts (1967) (creep of the softened asperities).
    Valid: the opposite of `contact_relaxation`; both may be there at different times.
    """

    name = "contact_creep"
    idea = "contact_relaxation"
    stage = Stage.PRESSURE
    reads, writes = ("contact_force_N",), ("contact_force_N",)
    strength = "per_decade"
    look = "in a hold the conductance rises while the force does not"

    per_decade: float = parameter(0.05, unit="1", low=0, high=0.5, doc="relative gain per decade of time")
    tau_s: float = parameter(1.0, unit="s", low=0.05, high=300, scale="log", doc="when the creep sets in")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        times, weights = spectra.logarithm(self.tau_s)
        gained = memory(signals["contact_force_N"], times, self.per_decade / np.log(10) * weights, dt_s)
        return {"contact_force_N": signals["contact_force_N"] + gained}


def guess_limit(effect: Effect, signals: Signals) -> Effect:
    """Start with a limit that the highest tenth of the measured force exceeds."""
    force_N = signals.get("force_N")
    if force_N is None:
        return effect
    top_N = max(float(np.quantile(np.abs(force_N), 0.9)), 1e-3)
    return effect.near(inverse_limit_per_N=1 / top_N)


def _limits(signals: Signals, quantiles: tuple[float, ...]) -> list[dict[str, Any]]:
    """Saturation at these quantiles of the contact force."""
    limits_N = (float(np.quantile(signals["contact_force_N"], q)) for q in quantiles)
    return [{"inverse_limit_per_N": 1 / limit_N} for limit_N in limits_N if limit_N > 1e-3]


class ContactSaturation(Effect):
    """All loops touch: more force makes no more contact, softly.

    P = P_0 / (1 + (inverse_limit |P_0|)^hardness)^(1 / hardness)

    Source: Greenwood & Williamson, Proc. R. Soc. A 295 (1966) 300 (no more contacts than asperities); the bend is
    the usual smooth minimum.
    Valid: 1 / inverse_limit is the pressing force that the contacts can use at most.
    """

    name = "contact_saturation"
    stage = Stage.PRESSURE
    reads, writes = ("contact_force_N",), ("contact_force_N",)
    strength = "inverse_limit_per_N"
    nonlinear = True
    imitated_by = "contact"
    look = "conductance bends to a plateau at high force, force does not"

    inverse_limit_per_N: float = parameter(
        0.3, unit="1/N", low=0, high=1e3, doc="inverse of the largest useful force"
    )
    hardness: float = parameter(3.0, unit="1", low=1, high=20, scale="log", doc="1: soft bend; 20: a corner")

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        points = _limits(signals, (0.5, 0.75, 0.9, 0.97))
        return [point | {"hardness": hardness} for point in points for hardness in (1.0, 2.0, 4.0)]

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        pressing_N = signals["contact_force_N"]
        load = self.inverse_limit_per_N * np.abs(pressing_N)
        # logaddexp(0, h ln load) is ln(1 + load^h) without overflow
        with np.errstate(divide="ignore"):
            bend = np.logaddexp(0.0, self.hardness * np.log(load)) / self.hardness
        return {"contact_force_N": pressing_N * np.exp(-bend)}

    def initial_guess(self, signals: Signals, dt_s: float) -> Effect:
        return guess_limit(self, signals)


class ContactSaturationHard(Effect):
    """All loops touch: above a limit more force makes no more contact at all.

    P = min(P_0, 1 / inverse_limit)

    Source: as `contact_saturation`.
    Valid: a corner, as a bottomed-out spacer fabric shows.
    """

    name = "contact_saturation_hard"
    idea = "contact_saturation"
    stage = Stage.PRESSURE
    reads, writes = ("contact_force_N",), ("contact_force_N",)
    strength = "inverse_limit_per_N"
    nonlinear = True
    imitated_by = "contact"
    look = "conductance stops rising at a certain force, force does not"

    inverse_limit_per_N: float = parameter(
        0.3, unit="1/N", low=0, high=1e3, doc="inverse of the largest useful force"
    )

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        return _limits(signals, (0.6, 0.75, 0.85, 0.93, 0.97))

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        limit_N = 1 / self.inverse_limit_per_N if self.inverse_limit_per_N > 0 else np.inf
        return {"contact_force_N": np.minimum(signals["contact_force_N"], limit_N)}

    def initial_guess(self, signals: Signals, dt_s: float) -> Effect:
        return guess_limit(self, signals)


class ContactSaturationBend(Effect):
    """Part of the contacts saturates: above a limit only a share of further force presses.

    P -= share * width * ln(1 + exp((P - limit) / width))

    Source: as `contact_saturation`; the bend is the usual smooth ramp.
    Valid: share 1 is full saturation.
    """

    name = "contact_saturation_bend"
    idea = "contact_saturation"
    stage = Stage.PRESSURE
    reads, writes = ("contact_force_N",), ("contact_force_N",)
    strength = "share"
    imitated_by = "contact"
    look = "conductance rises more slowly above a certain force, force does not"

    share: float = parameter(0.5, unit="1", low=0, high=1, doc="share of the further force that is lost")
    limit_N: float = parameter(1.0, unit="N", low=1e-3, high=1e3, scale="log", doc="force at the bend")
    width_N: float = parameter(0.1, unit="N", low=1e-4, high=1e2, scale="log", doc="force over which it bends")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        pressing_N = signals["contact_force_N"]
        beyond_N = self.width_N * np.logaddexp(0.0, (pressing_N - self.limit_N) / self.width_N)
        return {"contact_force_N": pressing_N - self.share * beyond_N}

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        pressing_N = signals["contact_force_N"]
        range_N = max(float(np.ptp(pressing_N)), 1e-2)
        limits_N = [float(np.quantile(pressing_N, q)) for q in (0.3, 0.55, 0.75, 0.9)]
        widths_N = (0.02 * range_N, 0.08 * range_N)
        return [{"limit_N": at, "width_N": width} for at in limits_N if at > 1e-3 for width in widths_N]

    def initial_guess(self, signals: Signals, dt_s: float) -> Effect:
        force_N = signals.get("force_N")
        if force_N is None:
            return self
        top_N = max(float(np.quantile(np.abs(force_N), 0.7)), 1e-3)
        return self.near(limit_N=top_N, width_N=0.05 * top_N)


class ContactHysteresis(Effect):
    """The contacts stick: the pressing force lags behind the force by friction of its own.

    P += friction * mean_k( stop_k(P_0) / r_k ),   r_k = threshold * spread_k

    Source: Kuhnen, Eur. J. Control 9 (2003) 407, Eqs. 4-9.
    Valid: rate-independent. A negative friction means that contacts are better on the way back.
    """

    name = "contact_hysteresis"
    stage = Stage.PRESSURE
    reads, writes = ("contact_force_N",), ("contact_force_N",)
    strength = "friction_N"
    look = "conductance over force is a loop, at any speed"

    friction_N: float = parameter(0.2, unit="N", low=-100, high=100, doc="shift of the pressing force when slipping")
    threshold_N: float = parameter(
        0.2, unit="N", low=1e-3, high=100, scale="log", doc="force after a reversal at which slip is under way"
    )

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        pressing_N = signals["contact_force_N"]
        return {"contact_force_N": pressing_N + self.friction_N * mean_slip(pressing_N, self.threshold_N)}

    def initial_guess(self, signals: Signals, dt_s: float) -> Effect:
        force_N = signals.get("force_N")
        if force_N is None:
            return self
        return self.near(threshold_N=0.05 * float(np.ptp(force_N)))
