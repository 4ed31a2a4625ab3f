"""The equations of the preset `pes`, written twice more without knitbench's operators: for bench_knit.py."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

from testbench.knit.filters import DEAD_BAND_STRAIN
from testbench.knit.mechanics.hysteresis import SPREAD
from testbench.knit.model import KnitModel

RATE_LAG_S = 0.1
STOPS = 8  # where the slip elements begin in the state
RK_STEP_S = 0.05  # the motion's fastest reversal takes about so long; RK45 steps over it otherwise
EFFECTS = (
    "permanent_set_recovering",
    "permanent_set_worked",
    "elasticity",
    "hysteresis",
    "stress_relaxation",
    "contact_relaxation",
    "contact_hysteresis",
    "contact",
    "electrical_overshoot",
    "electrical_overshoot_magnitude",
    "drift",
)


def parts_of(model: KnitModel) -> SimpleNamespace:
    """The model's effects as attributes; another set of effects needs other equations."""
    assert tuple(sorted(model.effects)) == tuple(sorted(EFFECTS)), "the preset changed: change these equations too"
    return SimpleNamespace(**model.effects)


def bare_force(m: Any, strain: float, slip: float) -> float:
    """Elastic force and friction."""
    e, h = m.elasticity, m.hysteresis
    width = max(1 + h.growth * strain, 0.0)
    return float(
        e.offset_N + e.stiffness_N * math.expm1(e.curvature * strain) / e.curvature + h.friction_N * width * slip
    )


def conductance_of(m: Any, pressing: float, sudden: float, shaken: float, time_s: float) -> float:
    """Holm's contact with both paths, then overshoot and drift."""
    c = m.contact
    softness = 0.1 * c.preload_N
    p = c.preload_N + pressing
    p = 0.5 * (p + math.sqrt(p * p + 4 * softness * softness))
    g = c.parallel_S + 1 / (c.series_ohm + c.contact_resistance_ohm / math.sqrt(p))
    log = m.electrical_overshoot.gain * sudden + m.electrical_overshoot_magnitude.gain * shaken
    return float(g * math.exp(log + m.drift.per_decade * math.log1p(time_s / m.drift.tau_s)))


class Filter:
    """First-order low-pass, exact for straight lines, one sample at a time."""

    def __init__(self, tau_s: float, dt_s: float, x: float) -> None:
        self.a = math.exp(-dt_s / tau_s)
        mean = (1 - self.a) * tau_s / dt_s
        self.b0, self.b1 = 1 - mean, mean - self.a
        self.x, self.y = x, x

    def step(self, x: float) -> float:
        self.y = self.a * self.y + self.b0 * x + self.b1 * self.x
        self.x = x
        return self.y


class Stops:
    """Mean of stop operators, one sample at a time."""

    def __init__(self, threshold: float, x: float) -> None:
        self.radii = [threshold * float(share) for share in SPREAD]
        self.stops, self.x = [0.0] * len(self.radii), x

    def step(self, x: float) -> float:
        moved, self.x = x - self.x, x
        self.stops = [min(max(s + moved, -r), r) for s, r in zip(self.stops, self.radii, strict=True)]
        return sum(s / r for s, r in zip(self.stops, self.radii, strict=True)) / len(self.radii)


def plain_python(model: KnitModel, strain: list[float], dt_s: float) -> list[float]:
    """Conductance, as one would first write it: objects with a step method, a loop over the samples."""
    m = parts_of(model)
    first = bare_force(m, strain[0], 0.0)
    worked, path = strain[0], 0.0
    set_lag = Filter(m.permanent_set_recovering.tau_s, dt_s, strain[0])
    friction = Stops(m.hysteresis.threshold, strain[0])
    relaxation = Filter(m.stress_relaxation.tau_s, dt_s, first)
    contact_relaxation = Filter(m.contact_relaxation.tau_s, dt_s, first)
    contact_friction = Stops(m.contact_hysteresis.threshold_N, first)
    sudden = Filter(m.electrical_overshoot.tau_s, dt_s, strain[0])
    rate_lag = Filter(RATE_LAG_S, dt_s, strain[0])
    shaking = Filter(m.electrical_overshoot_magnitude.tau_s, dt_s, 0.0)
    out = []
    for i, nominal in enumerate(strain):
        e = nominal
        if i:
            e -= m.permanent_set_recovering.fraction * (set_lag.step(nominal) - strain[0])
        before, worked = worked, min(max(worked, e - DEAD_BAND_STRAIN), e + DEAD_BAND_STRAIN)
        path += abs(worked - before)
        e += m.permanent_set_worked.amount * math.expm1(-path / m.permanent_set_worked.scale)
        bare = bare_force(m, e, friction.step(e))
        force = bare - m.stress_relaxation.fraction * ((relaxation.step(bare) if i else first) - first)
        pressing = force - m.contact_relaxation.fraction * ((contact_relaxation.step(force) if i else first) - first)
        pressing += m.contact_hysteresis.friction_N * contact_friction.step(pressing)
        lag = e - sudden.step(e) if i else 0.0
        speed = abs(e - rate_lag.step(e)) / RATE_LAG_S if i else 0.0
        shaken = m.electrical_overshoot_magnitude.tau_s * shaking.step(speed) if i else 0.0
        out.append(conductance_of(m, pressing, lag, shaken, i * dt_s))
    return out


class Equations:
    """The same as differential equations.

    State: five low-passes, the shaking, the path and its dead band, then both sets of stops.
    """

    def __init__(self, model: KnitModel) -> None:
        self.m = parts_of(model)
        self.slip_radii = [self.m.hysteresis.threshold * float(share) for share in SPREAD]
        self.contact_radii = [self.m.contact_hysteresis.threshold_N * float(share) for share in SPREAD]

    def start(self, strain: float) -> list[float]:
        """State of the resting knit."""
        self.strain0, self.first = strain, bare_force(self.m, strain, 0.0)
        return [strain, self.first, self.first, strain, strain, 0.0, 0.0, 0.0] + [0.0] * 2 * len(SPREAD)

    def _chain(self, nominal: float, y: Any) -> tuple[float, float, float, float]:
        m, n = self.m, len(SPREAD)
        e = nominal - m.permanent_set_recovering.fraction * (y[0] - self.strain0)
        e += m.permanent_set_worked.amount * math.expm1(-y[6] / m.permanent_set_worked.scale)
        slip = sum(s / r for s, r in zip(y[STOPS : STOPS + n], self.slip_radii, strict=True)) / n
        bare = bare_force(m, e, slip)
        force = bare - m.stress_relaxation.fraction * (y[1] - self.first)
        return e, bare, force, force - m.contact_relaxation.fraction * (y[2] - self.first)

    def derivative(self, nominal: float, nominal_rate: float, y: Any) -> list[float]:
        """Rate of change of the state."""
        m, n = self.m, len(SPREAD)
        e, bare, force, _ = self._chain(nominal, y)
        set_rate = (nominal - y[0]) / m.permanent_set_recovering.tau_s
        rate = nominal_rate - m.permanent_set_recovering.fraction * set_rate
        within = _stop_rate(y[7], DEAD_BAND_STRAIN, rate)
        path_rate, worked = abs(rate - within), m.permanent_set_worked
        rate -= worked.amount / worked.scale * math.exp(-y[6] / worked.scale) * path_rate
        slips = [_stop_rate(s, r, rate) for s, r in zip(y[STOPS : STOPS + n], self.slip_radii, strict=True)]
        relaxing = (bare - y[1]) / m.stress_relaxation.tau_s
        fading = (force - y[2]) / m.contact_relaxation.tau_s
        pressing_rate = self._bare_rate(e, rate, y, slips) - m.stress_relaxation.fraction * relaxing
        pressing_rate -= m.contact_relaxation.fraction * fading
        contacts = [_stop_rate(s, r, pressing_rate) for s, r in zip(y[STOPS + n :], self.contact_radii, strict=True)]
        filters = [set_rate, relaxing, fading, (e - y[3]) / m.electrical_overshoot.tau_s, (e - y[4]) / RATE_LAG_S]
        shaking = abs(e - y[4]) / RATE_LAG_S - y[5] / m.electrical_overshoot_magnitude.tau_s
        return [*filters, shaking, path_rate, within, *slips, *contacts]

    def _bare_rate(self, e: float, rate: float, y: Any, slips: list[float]) -> float:
        n, elastic, h = len(SPREAD), self.m.elasticity, self.m.hysteresis
        slip = sum(s / r for s, r in zip(y[STOPS : STOPS + n], self.slip_radii, strict=True)) / n
        slip_rate = sum(s / r for s, r in zip(slips, self.slip_radii, strict=True)) / n
        friction = h.friction_N * (h.growth * rate * slip + (1 + h.growth * e) * slip_rate)
        return float(elastic.stiffness_N * math.exp(elastic.curvature * e) * rate + friction)

    def conductance_S(self, nominal: float, time_s: float, y: Any) -> float:
        """Conductance that belongs to a state."""
        e, _, _, pressing = self._chain(nominal, y)
        stuck = sum(s / r for s, r in zip(y[STOPS + len(SPREAD) :], self.contact_radii, strict=True)) / len(SPREAD)
        pressing += self.m.contact_hysteresis.friction_N * stuck
        return conductance_of(self.m, pressing, e - y[3], y[5], time_s)


def _stop_rate(stop: float, radius: float, rate: float) -> float:
    return 0.0 if stop * rate > 0 and abs(stop) >= radius else rate
