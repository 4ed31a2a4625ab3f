"""Candidate effects and the trace each would leave in the measurement."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from testbench.fitting.baseline import SHAPES, framed
from testbench.fitting.measurement import Measurement
from testbench.knit.catalogue import BASELINE, Catalogue
from testbench.knit.effect import Effect, Signals, bounds_of
from testbench.knit.model import KnitModel

# Slip of the contacts is in the base already: contact_shape has slip elements of its own.
BASE_IDEAS = frozenset({*BASELINE, *SHAPES, "contact_hysteresis"})
MAX_SHAPES = 9  # shape-parameter combinations tried for one form
MAGNITUDES = (0.05, 0.15, 0.4, 1.0, 2.0)  # of a typical strength, for effects whose trace changes with their size


@dataclass(frozen=True)
class Candidate:
    """One form of one idea at one point of its shape parameters.

    Attributes
    ----------
    idea : str
        Physical idea; forms of one idea stand together.
    effect : Effect
        With the shape parameters of this point and a small strength.
    strength : float
        That strength; a trace's coefficient times it is the strength the data ask for.
    from_data : bool
        The strength is a level seen in the data (where a reading is clipped), not to be scaled.
    """

    idea: str
    effect: Effect
    strength: float
    from_data: bool = False

    @property
    def form(self) -> str:
        """Catalogue name of the form."""
        return self.effect.name

    def at(self, coefficient: float) -> Effect:
        """The effect at `coefficient` times the small strength, within its bounds."""
        if self.from_data or is_vector(type(self.effect), self.effect.strength):
            return self.effect
        if self.effect.nonlinear:
            # The trace of a threshold does not scale with it: stay near the point that was tried.
            coefficient = float(np.clip(coefficient, 0.7, 1.4))
        return self.effect.near(**{self.effect.strength: coefficient * self.strength})


def candidate_ideas(catalogue: Catalogue, model: KnitModel) -> dict[str, list[type[Effect]]]:
    """Ideas that could be missing: with a strength, not part of the base law, not in the model already."""
    present = {effect.idea or effect.name for effect in model.effects.values()}
    found: dict[str, list[type[Effect]]] = {}
    for idea, forms in catalogue.ideas().items():
        if idea in BASE_IDEAS or idea in present:
            continue
        usable = [form for form in forms if form.strength]
        if usable:
            found[idea] = usable
    return found


def is_vector(form: type[Effect], key: str) -> bool:
    """Whether a parameter is a vector of weights."""
    return isinstance(form.model_fields[key].default, tuple)


def expand(
    forms: Sequence[type[Effect]],
    idea: str,
    model: KnitModel,
    measurement: Measurement,
    state: Signals,
    residual: Signals,
) -> Iterator[Candidate]:
    """Every form over a coarse grid of its shape parameters, or over the grid it makes from the data itself."""
    for form in forms:
        if not all(signal in state for signal in form.reads):
            continue
        base = framed(form(), model, measurement).for_recording(state, residual, measurement.dt_s)
        if is_vector(form, form.strength):
            yield from _unit_vectors(base, idea)
            continue
        points = base.data_grid(state, residual, measurement.dt_s)
        for values in points or _shape_grid(form, measurement):
            seen = form.strength in values
            for strength in [values[form.strength]] if seen else _strengths(form):
                effect = base.near(**values | {form.strength: strength})
                yield Candidate(idea, effect, strength, seen)


def _unit_vectors(effect: Effect, idea: str) -> Iterator[Candidate]:
    """One candidate for each weight of a vector."""
    count, small = len(getattr(effect, effect.strength)), 0.01
    for index in range(count):
        weights = tuple(small if i == index else 0.0 for i in range(count))
        yield Candidate(idea, effect.replaced(**{effect.strength: weights}), small)


def _shape_grid(form: type[Effect], measurement: Measurement) -> list[dict[str, float]]:
    axes: dict[str, list[float]] = {}
    for key, field in form.model_fields.items():
        if key in (form.strength, *form.per_recording) or isinstance(field.default, tuple | bool | str):
            continue
        axes[key] = _grid_of(bounds_of(field), measurement)
    points = [dict(zip(axes, values, strict=True)) for values in itertools.product(*axes.values())]
    if len(points) <= MAX_SHAPES:
        return points
    return _one_at_a_time(form, axes)


def _one_at_a_time(form: type[Effect], axes: Mapping[str, list[float]]) -> list[dict[str, float]]:
    """Too many combinations: the defaults, and each parameter moved alone."""
    points: list[dict[str, float]] = [{}]
    for key, values in axes.items():
        points += [{key: value} for value in values if value != form.model_fields[key].default]
    return points


def _grid_of(extra: Mapping[str, object], measurement: Measurement) -> list[float]:
    low, high = float(extra["low"]), float(extra["high"])  # type: ignore[arg-type]
    if extra["scale"] != "log":
        return [low + share * (high - low) for share in (0.15, 0.5, 0.85)]
    if extra["unit"] == "s":
        # time constants that this recording can show: from a few samples to its length
        low = max(low, 3 * measurement.dt_s)
        high = max(min(high, float(measurement.signals["time_s"][-1])), 1.01 * low)
    count = int(np.clip(round(np.log10(high / low)) + 2, 3, 6))
    return list(np.geomspace(low, high, count + 2)[1:-1])


def _strengths(form: type[Effect]) -> list[float]:
    field = form.model_fields[form.strength]
    extra = bounds_of(field)
    typical = float(field.default) or 0.1 * float(extra["high"])
    if getattr(form, "nonlinear", False):
        return [float(np.clip(share * typical, extra["low"], extra["high"])) for share in MAGNITUDES]
    return [0.1 * abs(typical)]


def two_signed(form: type[Effect]) -> bool:
    """Whether the strength may be negative as well as positive."""
    extra = bounds_of(form.model_fields[form.strength])
    return extra["low"] < 0 < extra["high"]
