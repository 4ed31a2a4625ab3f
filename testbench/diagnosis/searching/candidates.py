"""Candidate effects and the trace each would leave in the measurement."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from testbench.fitting.baseline import framed
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect, Signals, bounds_of
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement

MAX_SHAPES = 9  # shape-parameter combinations tried for one law
MAGNITUDES = (0.05, 0.15, 0.4, 1.0, 2.0)  # of a typical strength, for effects whose trace changes with their size
SHARES = (0.15, 0.5, 0.85)  # of the range of a parameter, where it is tried
NEAR = (0.7, 1.4)  # times the strength that was tried: so far the trace of a threshold is nearly the same


@dataclass(frozen=True)
class Candidate:
    """One law at one point of its shape parameters.

    Attributes
    ----------
    effect : Effect
        With the shape parameters of this point and a small strength.
    strength : float
        That strength; a trace's coefficient times it is the strength the data ask for.
    from_data : bool
        The strength is a level seen in the data (where a reading is clipped), not to be scaled.
    """

    effect: Effect
    strength: float
    from_data: bool = False

    @property
    def law(self) -> str:
        """Catalogue name of the law."""
        return self.effect.name

    def at(self, coefficient: float) -> Effect:
        """The effect at `coefficient` times the small strength, within its bounds."""
        if self.from_data:
            return self.effect
        if self.effect.nonlinear:
            # The trace of a threshold does not scale with it: stay near the point that was tried.
            coefficient = float(np.clip(coefficient, *NEAR))
        return self.effect.near(**{self.effect.strength: coefficient * self.strength})


def candidate_mechanisms(catalogue: Catalogue, model: KnitModel) -> dict[str, list[type[Effect]]]:
    """Mechanisms that could be missing: with a strength, not part of the base laws, not in the model already."""
    present = {effect.mechanism for effect in model.effects.values()}
    found: dict[str, list[type[Effect]]] = {}
    for mechanism, laws in catalogue.mechanisms().items():
        if mechanism in present or any(law.in_base for law in laws):
            continue
        usable = [law for law in laws if law.strength]
        if usable:
            found[mechanism] = usable
    return found


def can_act(law: type[Effect], state: Signals) -> bool:
    """Whether there is all that a law reads: a sensor without a load cell may have no force."""
    return all(signal in state for signal in law.reads)


def is_vector(law: type[Effect], key: str) -> bool:
    """Whether a parameter is a vector of weights."""
    return isinstance(law.model_fields[key].default, tuple)


def expand(
    law: type[Effect], model: KnitModel, measurement: Measurement, state: Signals, residual: Signals
) -> Iterator[Candidate]:
    """A law at its own starts on these data, or over a coarse grid of its shape parameters."""
    if not can_act(law, state):
        return
    base = framed(law(), model, measurement)
    if is_vector(law, law.strength):
        yield from _unit_vectors(base.started(state, residual))
        return
    for values in base.starting_points(state, residual) or _shape_grid(law, measurement):
        from_data = law.strength in values
        for strength in [values[law.strength]] if from_data else _strengths(law):
            yield Candidate(base.near(**values | {law.strength: strength}), strength, from_data)


def _unit_vectors(effect: Effect) -> Iterator[Candidate]:
    """One candidate for each weight of a vector."""
    count, small = len(getattr(effect, effect.strength)), 0.01
    for index in range(count):
        weights = tuple(small if i == index else 0.0 for i in range(count))
        yield Candidate(effect.replaced(**{effect.strength: weights}), small)


def _shape_grid(law: type[Effect], measurement: Measurement) -> list[dict[str, float]]:
    axes: dict[str, list[float]] = {}
    for key, field in law.model_fields.items():
        if key in (law.strength, *law.per_recording) or isinstance(field.default, tuple | bool | str):
            continue
        axes[key] = _grid_of(bounds_of(field), measurement)
    points = [dict(zip(axes, values, strict=True)) for values in itertools.product(*axes.values())]
    if len(points) <= MAX_SHAPES:
        return points
    return _one_at_a_time(law, axes)


def _one_at_a_time(law: type[Effect], axes: Mapping[str, list[float]]) -> list[dict[str, float]]:
    """Too many combinations: the defaults, and each parameter moved alone."""
    points: list[dict[str, float]] = [{}]
    for key, values in axes.items():
        points += [{key: value} for value in values if value != law.model_fields[key].default]
    return points


def _grid_of(extra: Mapping[str, object], measurement: Measurement) -> list[float]:
    low, high = float(extra["low"]), float(extra["high"])  # type: ignore[arg-type]
    if extra["scale"] != "log":
        return [low + share * (high - low) for share in SHARES]
    if extra["unit"] == "s":
        # time constants that this recording can show: from a few samples to its length
        low = max(low, 3 * measurement.dt_s)
        high = max(min(high, float(measurement.signals["time_s"][-1])), 1.01 * low)
    count = int(np.clip(round(np.log10(high / low)) + 2, 3, 6))
    return list(np.geomspace(low, high, count + 2)[1:-1])


def _strengths(law: type[Effect]) -> list[float]:
    field = law.model_fields[law.strength]
    extra = bounds_of(field)
    strength = float(field.default) or 0.1 * float(extra["high"])
    if law.nonlinear:
        return [float(np.clip(share * strength, extra["low"], extra["high"])) for share in MAGNITUDES]
    return [0.1 * abs(strength)]


def two_signed(law: type[Effect]) -> bool:
    """Whether the strength may be negative as well as positive."""
    extra = bounds_of(law.model_fields[law.strength])
    return extra["low"] < 0 < extra["high"]
