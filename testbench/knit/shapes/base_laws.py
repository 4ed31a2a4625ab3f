"""Shape freedom of the base laws: what an elastic, hysteretic, contact or drift law cannot bend to by itself.

A stiff base law makes every candidate effect imitate its own misfit. These additions are linear in their weights,
smooth, and zero by default, so that a fit can charge a physical effect only for what no reasonable shape of the base
law explains. When one of them alone removes the misfit, the finding is "the base law itself misfits".
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from testbench.knit.additive import ConductanceLaw, ForceLaw
from testbench.knit.effect import FloatArray, Signals, Stage, Vector, parameter, zeros
from testbench.knit.shapes.curves import CURVE_TERMS, LAW_TERMS, curve, curve_terms, kept_curve
from testbench.knit.shapes.loops import LOOPS, STOPS, WAYS, loops, loops_by_weight, two_ways

DRIFT_TAUS_S = (3.0, 30.0, 300.0)
DRIFT_BUMPS = 6


@lru_cache(maxsize=8)
def _settled(start_s: float, end_s: float, count: int) -> FloatArray:
    """What has settled with each of `DRIFT_TAUS_S` on a uniform grid, shape (3, count): the same in every run."""
    return -np.expm1(-np.linspace(start_s, end_s, count) / np.array(DRIFT_TAUS_S)[:, None])


def _ending(signals: Signals) -> FloatArray:
    """Drift that ends within each of `DRIFT_TAUS_S`, shape (3, n)."""
    t = signals["time_s"]
    return _settled(float(t[0]), float(t[-1]), len(t))


def _drifts(signals: Signals) -> FloatArray:
    """The same, and drift that does not end, shape (4, n)."""
    return np.vstack((_ending(signals), signals["time_s"] / 1000))


class ElasticityShape(ForceLaw):
    """Any smooth correction to the elastic law over strain, knees included.

    F += w_1 x + w_2 x^2 + sum_k w_k cos(k pi x) / k^2,   x = e / span

    Source: smoothing splines as a cosine series, Wahba, Spline Models for Observational Data (1990), ch. 2: weights
    of one size make a curve whose slope wanders. Valid: inside the strain seen in the fit.
    """

    name = "elasticity_shape"
    in_base = True
    strength = "weights_N"
    look = "the misfit of force depends on strain alone"

    weights_N: Vector = zeros(CURVE_TERMS, unit="N", most=1e3, doc="weight of each term over strain")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain covered by the curve")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        return curve(signals["strain"], 0.0, self.span, self.weights_N)

    def terms(self, parameter: str, signals: Signals) -> FloatArray:
        return curve_terms(signals["strain"], 0.0, self.span, len(self.weights_N))


class HysteresisShape(ForceLaw):
    """Rate-independent loops of the force of any width, sharp or smooth, that may widen or narrow with strain.

    F += sum_k (w_k + v_k u + v'_k u^2) z_k(e) + sum_k q_k (u^2 - p_k^2) / r_k,   u = e / span

    z_k: stops (Prandtl-Ishlinskii), Bouc-Wen variables, and followers that close their gap over one length of travel
    upwards and over another downwards. p_k: position of a play of radius r_k; with its square the loops are those of
    a Preisach operator whose density changes along the strain (`testbench.knit.shapes.loops`).

    Source: Kuhnen, Eur. J. Control 9 (2003) 407 (free Prandtl-Ishlinskii weights); Wen, J. Eng. Mech. Div. ASCE 102
    (1976) 249; Valanis, Arch. Mech. 23 (1971) 517 (memory over travel); Brokate & Sprekels, Hysteresis and Phase
    Transitions (1996), ch. 2 (Preisach). Valid: rate-independent loops.
    """

    name = "hysteresis_shape"
    in_base = True
    strength = "weights_N"
    look = "the misfit of force depends on the direction of motion and on the last reversals, at any speed"

    weights_N: Vector = zeros(LOOPS, unit="N", most=1e3, doc="friction of each")
    growth_N: Vector = zeros(2 * LOOPS, unit="N", most=1e3, doc="its growth over the strain span and its square")
    positions_N: Vector = zeros(len(STOPS), unit="N", most=1e3, doc="weight of the squared position of each play")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain over which growth is counted")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        return loops(signals["strain"], self.span, self.weights_N, self.growth_N, self.positions_N)

    def terms(self, parameter: str, signals: Signals) -> FloatArray:
        return loops_by_weight(parameter.removesuffix("_N"), signals["strain"], self.span)


class ContactShape(ConductanceLaw):
    """Any smooth correction to the law of conductance over contact force and strain.

    ln G += curve(sqrt((P - low_N) / span_N)) + curve(e / span),   the curves as in `elasticity_shape`

    Contacts conduct with about the root of what presses them (Holm): there a smooth curve sees light loads, too.

    Source: Wahba, Spline Models for Observational Data (1990), ch. 2. Valid: inside the force and strain seen in the
    fit.
    """

    name = "contact_shape"
    in_base = True
    stage = Stage.CONTACT
    optional_reads = ("contact_force_N",)
    pointwise = ("contact_force_N",)
    strength = "strain_weights"
    look = "the misfit of ln G depends on force and strain, at any speed and time"

    force_weights: Vector = zeros(CURVE_TERMS, unit="1", most=3, doc="weight of each term over contact force")
    strain_weights: Vector = zeros(CURVE_TERMS, unit="1", most=3, doc="weight of each term over strain")
    low_N: float = parameter(0.0, unit="N", low=-1e3, high=1e3, doc="contact force where the curve begins")
    span_N: float = parameter(3.0, unit="N", low=1e-3, high=1e4, doc="contact force covered by the curve")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain covered by the curve")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        log_change = kept_curve(signals["strain"], 0.0, self.span, self.strain_weights)
        if "contact_force_N" in signals:
            log_change = log_change + curve(self._load(signals), 0.0, 1.0, self.force_weights)
        return log_change

    def terms(self, parameter: str, signals: Signals) -> FloatArray | None:
        if parameter == "strain_weights":
            return curve_terms(signals["strain"], 0.0, self.span, len(self.strain_weights))
        if "contact_force_N" not in signals:
            return None
        return curve_terms(self._load(signals), 0.0, 1.0, len(self.force_weights))

    def _load(self, signals: Signals) -> FloatArray:
        return np.sqrt(np.maximum((signals["contact_force_N"] - self.low_N) / self.span_N, 0.0))


class DriftShape(ConductanceLaw):
    """Drift of the conductance on several time scales at once.

    ln G += sum_k w_k (1 - exp(-t / tau_k)) + slope * t / 1000 s,   tau = 3, 30, 300 s

    Source: Prony series of a monotonic relaxation, Tschoegl (1989), ch. 3. Valid: one recording from its start.
    """

    name = "drift_shape"
    in_base = True
    reads = ("time_s", "conductance_S")
    strength = "weights"
    look = "the misfit of ln G depends on elapsed time alone"

    weights: Vector = zeros(len(DRIFT_TAUS_S), unit="1", most=5, doc="drift that ends within each time scale")
    slope_per_ks: float = parameter(0.0, unit="1/ks", low=-5, high=5, doc="drift that does not end")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return np.asarray(self.weights) @ _ending(signals) + self.slope_per_ks * signals["time_s"] / 1000

    def terms(self, parameter: str, signals: Signals) -> FloatArray:
        return _ending(signals)


class ContactDriftShape(ConductanceLaw):
    """Drift of the contacts alone: how much it changes ln G depends on how hard they are pressed.

    ln G += sum_j B_j((P - low_N) / span_N) * (sum_k w_jk (1 - exp(-t / tau_k)) + w_j3 t / 1000 s)
    tau = 3, 30, 300 s

    Paths beside the contacts (floats) and in series (yarn) hide part of what the contacts do, each at its own load.

    Source: Prony series as in `drift_shape`; penalised splines, Eilers & Marx, Statist. Sci. 11 (1996) 89.
    Valid: one recording from its start; inside the contact force seen in the fit.
    """

    name = "contact_drift_shape"
    in_base = True
    stage = Stage.CONTACT
    reads = ("time_s", "strain", "conductance_S")
    optional_reads = ("contact_force_N",)
    pointwise = ("contact_force_N",)
    strength = "weights"
    look = "the conductance creeps, and how much depends on the load"

    weights: Vector = zeros(DRIFT_BUMPS * (len(DRIFT_TAUS_S) + 1), unit="1", most=5, doc="drift by bump and time")
    low_N: float = parameter(0.0, unit="N", low=-1e3, high=1e3, doc="contact force where the bumps begin")
    span_N: float = parameter(3.0, unit="N", low=1e-3, high=1e4, doc="contact force covered by the bumps")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain covered by the bumps, without a force")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        from testbench.knit.shapes.splines import bsplines_over

        if not any(self.weights):
            return np.zeros_like(signals["time_s"])
        return bsplines_over(self._load(signals), np.reshape(self.weights, (DRIFT_BUMPS, -1)), _drifts(signals))

    def terms(self, parameter: str, signals: Signals) -> FloatArray:
        from testbench.knit.shapes.splines import bspline

        load = self._load(signals)
        bumps = np.stack([bspline(load, one) for one in np.eye(DRIFT_BUMPS)])
        return (bumps[:, None] * _drifts(signals)).reshape(-1, len(load))

    def _load(self, signals: Signals) -> FloatArray:
        if "contact_force_N" in signals:
            return (signals["contact_force_N"] - self.low_N) / self.span_N
        return signals["strain"] / self.span


class ContactLoopsShape(ConductanceLaw):
    """Rate-independent loops of ln G over strain: of any width, sharp or smooth, or with two curves for the two ways.

    ln G += sum_k (w_k + v_k u + v'_k u^2) z_k(e) + sum_j z_j(e) curve_j(u),   u = e / span

    z_k as in `hysteresis_shape`; z_j are Bouc-Wen variables, -1 on the way back and 1 on the way out; the curves are
    those of `elasticity_shape`.

    Source: as `hysteresis_shape`. Valid: rate-independent loops.
    """

    name = "contact_loops_shape"
    in_base = True
    stage = Stage.CONTACT
    strength = "weights"
    look = "conductance over strain is a loop, at any speed"

    weights: Vector = zeros(LOOPS, unit="1", most=3, doc="width of each loop in ln G")
    growth: Vector = zeros(2 * LOOPS, unit="1", most=3, doc="its growth over the strain span and its square")
    ways: Vector = zeros(len(WAYS) * LAW_TERMS, unit="1", most=3, doc="curve by which the two ways differ")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain over which growth is counted")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        e, span = signals["strain"], self.span
        return loops(e, span, self.weights, self.growth) + two_ways(e, span, self.ways)

    def terms(self, parameter: str, signals: Signals) -> FloatArray:
        return loops_by_weight(parameter, signals["strain"], self.span)
