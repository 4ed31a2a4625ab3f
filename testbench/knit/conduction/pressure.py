"""Force that presses the contacts: it may saturate and stick apart from the force that is measured."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Points, Signals, Stage, parameter
from testbench.knit.mechanics.hysteresis import mean_slip


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
    in_base = True
    also_from = ({"strain_share": 0.0},)
    stage = Stage.PRESSURE
    reads, writes = ("strain", "contact_force_N"), ("contact_force_N",)
    pointwise = ("contact_force_N",)
    look = "the conductance does not follow the loops and the relaxation that the force shows"

    strain_share: float = parameter(0.0, unit="1", low=0, high=1, doc="0: force alone, 1: strain alone")
    low_N: float = parameter(0.0, unit="N", low=-1e3, high=1e3, doc="force that stands for zero strain")
    span_N: float = parameter(3.0, unit="N", low=1e-3, high=1e4, doc="rise of force that stands for the whole span")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain at the end of the span")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        by_strain_N = self.low_N + self.span_N * signals["strain"] / self.span
        felt_N = signals["contact_force_N"] + self.strain_share * (by_strain_N - signals["contact_force_N"])
        return {"contact_force_N": felt_N}


def _limits(signals: Signals, quantiles: tuple[float, ...]) -> Points:
    """Saturation at these quantiles of the contact force."""
    limits_N = (float(np.quantile(signals["contact_force_N"], q)) for q in quantiles)
    return [{"inverse_limit_per_N": 1 / limit_N} for limit_N in limits_N if limit_N > 1e-3]


class ContactSaturationLaw(Effect):
    """Base of the laws of contacts that saturate."""

    mechanism = "contact_saturation"
    bends_a_law = True
    stage = Stage.PRESSURE
    reads, writes = ("contact_force_N",), ("contact_force_N",)
    pointwise = ("contact_force_N",)
    strength = "inverse_limit_per_N"


class ContactSaturation(ContactSaturationLaw):
    """All loops touch: more force makes no more contact, softly.

    P = P_0 / (1 + (inverse_limit |P_0|)^hardness)^(1 / hardness)

    Source: Greenwood & Williamson, Proc. R. Soc. A 295 (1966) 300 (no more contacts than asperities); the bend is
    the usual smooth minimum.
    Valid: 1 / inverse_limit is the pressing force that the contacts can use at most.
    """

    name = "contact_saturation"
    nonlinear = True
    look = "conductance bends to a plateau at high force, force does not"

    inverse_limit_per_N: float = parameter(0.3, unit="1/N", low=0, high=1e3, doc="1 / the largest useful force")
    hardness: float = parameter(3.0, unit="1", low=1, high=20, scale="log", doc="1: soft bend; 20: a corner")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        points = _limits(signals, (0.5, 0.75, 0.9, 0.97))
        return [point | {"hardness": hardness} for point in points for hardness in (1.0, 2.0, 4.0)]

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        pressing_N = signals["contact_force_N"]
        load = self.inverse_limit_per_N * np.abs(pressing_N)
        # logaddexp(0, h ln load) is ln(1 + load^h) without overflow
        with np.errstate(divide="ignore"):
            bend = np.logaddexp(0.0, self.hardness * np.log(load)) / self.hardness
        return {"contact_force_N": pressing_N * np.exp(-bend)}


class ContactSaturationHard(ContactSaturationLaw):
    """All loops touch: above a limit more force makes no more contact at all.

    P = min(P_0, 1 / inverse_limit)

    Source: as `contact_saturation`.
    Valid: a corner, as a bottomed-out spacer fabric shows.
    """

    name = "contact_saturation_hard"
    nonlinear = True
    look = "conductance stops rising at a certain force, force does not"

    inverse_limit_per_N: float = parameter(0.3, unit="1/N", low=0, high=1e3, doc="1 / the largest useful force")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return _limits(signals, (0.6, 0.75, 0.85, 0.93, 0.97))

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        limit_N = 1 / self.inverse_limit_per_N if self.inverse_limit_per_N > 0 else np.inf
        return {"contact_force_N": np.minimum(signals["contact_force_N"], limit_N)}


class ContactSaturationBend(ContactSaturationLaw):
    """Part of the contacts saturates: above a limit only a share of further force presses.

    P -= share * width * ln(1 + exp((P - limit) / width))

    Source: as `contact_saturation`; the bend is the usual smooth ramp.
    Valid: share 1 is full saturation.
    """

    name = "contact_saturation_bend"
    strength = "share"
    look = "conductance rises more slowly above a certain force, force does not"

    share: float = parameter(0.5, unit="1", low=0, high=1, doc="share of the further force that is lost")
    limit_N: float = parameter(1.0, unit="N", low=1e-3, high=1e3, scale="log", doc="force at the bend")
    width_N: float = parameter(0.1, unit="N", low=1e-4, high=1e2, scale="log", doc="force over which it bends")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        pressing_N = signals["contact_force_N"]
        beyond_N = self.width_N * np.logaddexp(0.0, (pressing_N - self.limit_N) / self.width_N)
        return {"contact_force_N": pressing_N - self.share * beyond_N}

    def starts(self, signals: Signals, residual: Signals) -> Points:
        pressing_N = signals["contact_force_N"]
        range_N = max(float(np.ptp(pressing_N)), 1e-2)
        limits_N = [float(np.quantile(pressing_N, q)) for q in (0.3, 0.55, 0.75, 0.9)]
        widths_N = (0.02 * range_N, 0.08 * range_N)
        return [{"limit_N": at, "width_N": width} for at in limits_N if at > 1e-3 for width in widths_N]


class ContactHysteresis(Effect):
    """The contacts stick: the pressing force lags behind the force by friction of its own.

    P += friction * mean_k( stop_k(P_0) / r_k ),   r_k = threshold * spread_k

    Source: Kuhnen, Eur. J. Control 9 (2003) 407, Eqs. 4-9.
    Valid: rate-independent. A negative friction means that contacts are better on the way back.
    """

    name = "contact_hysteresis"
    in_base = True  # `contact_shape` has slip elements of its own
    stage = Stage.PRESSURE
    reads, writes = ("contact_force_N",), ("contact_force_N",)
    strength = "friction_N"
    look = "conductance over force is a loop, at any speed"

    friction_N: float = parameter(0.2, unit="N", low=-100, high=100, doc="shift of the pressing force when slipping")
    threshold_N: float = parameter(0.2, unit="N", low=1e-3, high=100, scale="log", doc="force from a turn to slip")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        pressing_N = signals["contact_force_N"]
        return {"contact_force_N": pressing_N + self.friction_N * mean_slip(pressing_N, self.threshold_N)}
