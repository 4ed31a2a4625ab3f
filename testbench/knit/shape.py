"""Shape freedom of the base laws: what an elastic, hysteretic, contact or drift law cannot bend to by itself.

A stiff base law makes every candidate effect a stand-in for its own misfit. These additions are linear in their
weights, smooth, and zero by default, so that a fit can charge a physical effect only for what no reasonable shape of
the base law explains. When one of them alone removes the misfit, the finding is "the base law itself misfits".
"""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter

SPLINE_KNOTS = 14
SLIP_STRAINS = (0.001, 0.12)  # break-away strains of the first and the last slip element,
SLIP_SPAN = 0.3  # over this span
LOOP_SLIPS, CONTACT_SLIPS = 12, 9
DRIFT_TAUS_S = (3.0, 30.0, 300.0)
DRIFT_BUMPS = 6
SMOOTH_LOOPS, LOOP_THRESHOLDS, LOOP_SKEWS = 12, (0.004, 0.25), (0.0, 0.5)  # thresholds in parts of the span


def spline(x: FloatArray, weights: tuple[float, ...]) -> FloatArray:
    """Smooth curve over 0 <= x <= 1; see `testbench.knit.kernels.bspline`."""
    from testbench.knit.kernels import bspline

    return bspline(x, np.asarray(weights))


@cache
def _slip_strains(count: int) -> FloatArray:
    """Break-away strains of so many slip elements over `SLIP_SPAN`, shape (count,): asked for at every simulation."""
    return np.geomspace(*SLIP_STRAINS, count)


def slips(
    e: FloatArray, span: float, weights: tuple[float, ...], growth: tuple[float, ...] | None = None
) -> FloatArray:
    """Weighted stop operators in the range of `SLIP_STRAINS`, scaled to the span; weights grow over the strain."""
    from testbench.knit.kernels import weighted_stops

    thresholds = _slip_strains(len(weights)) * span / SLIP_SPAN
    per_strain = np.zeros(len(weights)) if growth is None else np.asarray(growth) / span
    return weighted_stops(e, thresholds, np.asarray(weights), per_strain)


@lru_cache(maxsize=8)
def _settled(start_s: float, end_s: float, count: int) -> FloatArray:
    """What has settled with each of `DRIFT_TAUS_S` on a uniform grid, shape (3, count): the same in every run."""
    return -np.expm1(-np.linspace(start_s, end_s, count) / np.array(DRIFT_TAUS_S)[:, None])


class ElasticityShape(Effect):
    """Any smooth correction to the elastic law over strain.

    F += sum_j w_j B_j(e / span)

    Source: penalised splines, Eilers & Marx, Statist. Sci. 11 (1996) 89. Valid: inside the strain seen in the fit.
    """

    name = "elasticity_shape"
    stage = Stage.MECHANICS
    reads, writes = ("strain", "force_N"), ("force_N",)
    strength = "weights_N"
    look = "the misfit of force depends on strain alone"

    weights_N: tuple[float, ...] = parameter(
        (0.0,) * SPLINE_KNOTS, unit="N", low=-1e3, high=1e3, doc="height of each bump over strain"
    )
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain covered by the bumps")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"force_N": signals["force_N"] + spline(signals["strain"] / self.span, self.weights_N)}


class HysteresisShape(Effect):
    """Any distribution of slip strains, with loops that may widen or narrow with strain.

    F += sum_k (w_k + v_k e / span) * stop_k(e) / r_k

    Source: Kuhnen, Eur. J. Control 9 (2003) 407 (free Prandtl-Ishlinskii weights). Valid: rate-independent loops.
    """

    name = "hysteresis_shape"
    stage = Stage.MECHANICS
    reads, writes = ("strain", "force_N"), ("force_N",)
    strength = "weights_N"
    look = "the misfit of force depends on the direction of motion and on the last reversals, at any speed"

    weights_N: tuple[float, ...] = parameter(
        (0.0,) * LOOP_SLIPS, unit="N", low=-1e3, high=1e3, doc="friction of each slip element"
    )
    growth_N: tuple[float, ...] = parameter(
        (0.0,) * LOOP_SLIPS, unit="N", low=-1e3, high=1e3, doc="its growth over the strain span"
    )
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain over which growth is counted")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        friction = slips(signals["strain"], self.span, self.weights_N, self.growth_N)
        return {"force_N": signals["force_N"] + friction}


class ContactShape(Effect):
    """Any smooth correction to the law of conductance over contact force and strain, with hysteresis of its own.

    ln G += sum_j w_j B_j(P / span_N) + sum_j u_j B_j(e / span) + sum_k (v_k + z_k e / span) stop_k(e) / r_k

    Source: penalised splines, Eilers & Marx, Statist. Sci. 11 (1996) 89; slip as in `hysteresis_shape`.
    Valid: inside the force and strain seen in the fit.
    """

    name = "contact_shape"
    stage = Stage.CONTACT
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    optional_reads = ("contact_force_N",)
    strength = "strain_weights"
    look = "the misfit of ln G depends on force, strain and direction, at any speed and time"

    force_weights: tuple[float, ...] = parameter(
        (0.0,) * SPLINE_KNOTS, unit="1", low=-3, high=3, doc="height of each bump over contact force"
    )
    strain_weights: tuple[float, ...] = parameter(
        (0.0,) * SPLINE_KNOTS, unit="1", low=-3, high=3, doc="height of each bump over strain"
    )
    slip_weights: tuple[float, ...] = parameter(
        (0.0,) * CONTACT_SLIPS, unit="1", low=-3, high=3, doc="change of ln G when a slip element has slipped"
    )
    slip_growth: tuple[float, ...] = parameter(
        (0.0,) * CONTACT_SLIPS, unit="1", low=-3, high=3, doc="its growth over the strain span"
    )
    low_N: float = parameter(0.0, unit="N", low=-1e3, high=1e3, doc="contact force where the bumps begin")
    span_N: float = parameter(3.0, unit="N", low=1e-3, high=1e4, doc="contact force covered by the bumps")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain covered by the bumps")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        e = signals["strain"]
        log_change = spline(e / self.span, self.strain_weights) + slips(
            e, self.span, self.slip_weights, self.slip_growth
        )
        if "contact_force_N" in signals:
            force = (signals["contact_force_N"] - self.low_N) / self.span_N
            log_change = log_change + spline(force, self.force_weights)
        return {"conductance_S": signals["conductance_S"] * np.exp(log_change)}


class DriftShape(Effect):
    """Drift of the conductance on several time scales at once.

    ln G += sum_k w_k (1 - exp(-t / tau_k)) + slope * t / 1000 s,   tau = 3, 30, 300 s

    Source: Prony series of a monotonic relaxation, Tschoegl (1989), ch. 3. Valid: one recording from its start.
    """

    name = "drift_shape"
    stage = Stage.ELECTRICAL
    reads, writes = ("time_s", "conductance_S"), ("conductance_S",)
    strength = "weights"
    look = "the misfit of ln G depends on elapsed time alone"

    weights: tuple[float, ...] = parameter(
        (0.0,) * len(DRIFT_TAUS_S), unit="1", low=-5, high=5, doc="drift that ends within each time scale"
    )
    slope_per_ks: float = parameter(0.0, unit="1/ks", low=-5, high=5, doc="drift that does not end")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        t = signals["time_s"]
        settled = _settled(float(t[0]), float(t[-1]), len(t))
        log_change = np.asarray(self.weights) @ settled + self.slope_per_ks * t / 1000
        return {"conductance_S": signals["conductance_S"] * np.exp(log_change)}


class ContactDriftShape(Effect):
    """Drift of the contacts alone: how much it changes ln G depends on how hard they are pressed.

    ln G += sum_j B_j(P / span_N) * (sum_k w_jk (1 - exp(-t / tau_k)) + w_j3 t / 1000 s),   tau = 3, 30, 300 s

    Paths beside the contacts (floats) and in series (yarn) hide part of what the contacts do, each at its own load.

    Source: Prony series as in `drift_shape`; penalised splines, Eilers & Marx, Statist. Sci. 11 (1996) 89.
    Valid: one recording from its start; inside the contact force seen in the fit.
    """

    name = "contact_drift_shape"
    stage = Stage.CONTACT
    reads, writes = ("time_s", "strain", "conductance_S"), ("conductance_S",)
    optional_reads = ("contact_force_N",)
    strength = "weights"
    look = "the conductance creeps, and how much depends on the load"

    weights: tuple[float, ...] = parameter(
        (0.0,) * (DRIFT_BUMPS * (len(DRIFT_TAUS_S) + 1)), unit="1", low=-5, high=5, doc="drift at each bump and time"
    )
    low_N: float = parameter(0.0, unit="N", low=-1e3, high=1e3, doc="contact force where the bumps begin")
    span_N: float = parameter(3.0, unit="N", low=1e-3, high=1e4, doc="contact force covered by the bumps")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain covered by the bumps, without a force")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        from testbench.knit.kernels import bspline

        t = signals["time_s"]
        times = [*_settled(float(t[0]), float(t[-1]), len(t)), t / 1000]
        load = signals["strain"] / self.span
        if "contact_force_N" in signals:
            load = (signals["contact_force_N"] - self.low_N) / self.span_N
        weights = np.reshape(self.weights, (DRIFT_BUMPS, -1))
        drifts = (bspline(load, weights[:, k].copy()) * one for k, one in enumerate(times) if weights[:, k].any())
        return {"conductance_S": signals["conductance_S"] * np.exp(sum(drifts, np.zeros_like(t)))}


class ContactLoopsShape(Effect):
    """Smooth loops of ln G over strain, of any width, that may widen or narrow with strain.

    ln G += sum_k (w_k + v_k e / span) z_k(e),   z_k: Bouc-Wen variables of many thresholds and two skews

    Source: Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249. Valid: rate-independent loops.
    """

    name = "contact_loops_shape"
    stage = Stage.CONTACT
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    strength = "weights"
    look = "conductance over strain is a loop with smooth corners, at any speed"

    weights: tuple[float, ...] = parameter(
        (0.0,) * SMOOTH_LOOPS, unit="1", low=-3, high=3, doc="width of each loop in ln G"
    )
    growth: tuple[float, ...] = parameter(
        (0.0,) * SMOOTH_LOOPS, unit="1", low=-3, high=3, doc="its growth over the strain span"
    )
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain over which growth is counted")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        e = signals["strain"]
        weights, growth = np.asarray(self.weights), np.asarray(self.growth)
        if not (weights.any() or growth.any()):
            return {"conductance_S": signals["conductance_S"].copy()}
        z = _loops(e, self.span)
        log_change = weights @ z + (growth @ z) * (e / self.span)
        return {"conductance_S": signals["conductance_S"] * np.exp(log_change)}


_LAST_LOOPS: list[tuple[FloatArray, float, FloatArray]] = []  # newest last


def _loops(e: FloatArray, span: float) -> FloatArray:
    """Bouc-Wen variables over a strain, shape (SMOOTH_LOOPS, n); they do not depend on any weight."""
    from testbench.knit.kernels import bouc_wen

    for seen, at, z in tuple(_LAST_LOOPS):
        if seen is e and at == span:
            return z
    thresholds = np.geomspace(*LOOP_THRESHOLDS, SMOOTH_LOOPS // 2) * span
    z = np.stack([bouc_wen(e, threshold, skew) for skew in LOOP_SKEWS for threshold in thresholds])
    _LAST_LOOPS.append((e, span, z))
    del _LAST_LOOPS[:-6]
    return z
