"""A small picture of what an effect does: the same motion without and with it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gcode.support.colours import BLUE, GREY
from gcode.support.files import atomic_path
from testbench.knit.catalogue import baseline
from testbench.knit.effect import Effect, FloatArray, Signals, Stage, bounds_of
from testbench.knit.model import KnitModel, inputs

DT_S = 0.05
VISIBLE = 0.15  # wanted change of the curve, as a share of its span


@dataclass(frozen=True)
class Showcase:
    """Curves without and with the effect.

    Attributes
    ----------
    time_s, strain, without, with_it : ndarray, each shape (n,)
    label : str
        What is shown, with its unit.
    effect : Effect
        With the parameters that make it visible.
    """

    time_s: FloatArray
    strain: FloatArray
    without: FloatArray
    with_it: FloatArray
    label: str
    effect: Effect


def motion(period_s: float) -> tuple[FloatArray, FloatArray]:
    """Strain over time: small triangles, a hold, fast and large triangles, a rest."""
    corners = [0, 0.12, 0, 0.12, 0, 0.22, 0.22, 0.05, 0.3, 0, 0.3, 0, 0, 0.12, 0]
    lengths = [1, 1, 1, 1, 1, 4, 1, 0.4, 0.6, 1.5, 1.5, 3, 1, 1]
    at = np.concatenate([[0], np.cumsum(lengths)]) * period_s
    time_s = np.arange(0, at[-1], DT_S)
    return time_s, np.interp(time_s, at, corners)


def slow(effect: Effect) -> bool:
    """Whether the effect needs minutes to show."""
    times = [getattr(effect, key) for key in type(effect).model_fields if key.endswith("_s") and key != "when_s"]
    return max(times, default=0.0) > 50 or effect.name in ("drift", "drift_power", "temperature_drift_trend")


def showcase(cls: type[Effect]) -> Showcase:
    """Simulate the showcase of one effect, its strength raised until it can be seen."""
    effect = cls()
    time_s, strain = motion(60.0 if slow(effect) else 5.0)
    model = baseline().without("drift") if cls.stage is Stage.ELECTRICAL else baseline()
    without = _curves(_without_namesake(model, effect), time_s, strain)
    key = "force_N" if "force_N" in effect.writes or cls.stage is Stage.KINEMATICS else "conductance_S"
    scale, label = (1.0, "force / N") if key == "force_N" else (1e6, "conductance / µS")
    effect = visible(model, effect, time_s, strain, key)
    with_it = _curves(_with(model, effect), time_s, strain)
    return Showcase(time_s, strain, scale * without[key], scale * with_it[key], label, effect)


def _without_namesake(model: KnitModel, effect: Effect) -> KnitModel:
    removable = effect.name in model and bool(effect.strength)
    return model.without(effect.name) if removable else model


def _with(model: KnitModel, effect: Effect) -> KnitModel:
    if effect.name in model:
        return model.replacing(effect.name, effect)
    law = effect.stage is Stage.CONTACT and not effect.strength
    return (model.without("contact") if law else model).plus(effect)


def _curves(model: KnitModel, time_s: FloatArray, strain: FloatArray) -> dict[str, FloatArray]:
    return model.simulate(inputs(time_s, strain, 23 + 2 * np.sin(time_s / time_s[-1] * 6)), DT_S)


def visible(model: KnitModel, effect: Effect, time_s: FloatArray, strain: FloatArray, key: str) -> Effect:
    """The effect with its strength raised, within bounds, until the curve changes by `VISIBLE` of its span."""
    if not effect.strength:
        return effect
    if isinstance(weights := getattr(effect, effect.strength), tuple):
        return effect.replaced(**{effect.strength: tuple(0.6 * np.sin(np.linspace(0, 6, len(weights))))})
    extra = bounds_of(type(effect).model_fields[effect.strength])
    plain = _curves(_without_namesake(model, effect), time_s, strain)[key]
    effect = _midway(effect, _curves(model, time_s, strain)) if effect.nonlinear else effect
    for _ in range(12):
        changed = _curves(_with(model, effect), time_s, strain)[key]
        share = float(np.max(np.abs(changed - plain)) / np.ptp(plain))
        strength = getattr(effect, effect.strength) * 1.6
        if share > VISIBLE or not extra["low"] <= strength <= extra["high"]:
            break
        effect = effect.replaced(**{effect.strength: strength})
    return effect


def _midway(effect: Effect, signals: Signals) -> Effect:
    """The effect in the middle of its starts on these signals: a level, a limit that they reach."""
    points = effect.starting_points(signals, {})
    return effect.near(**points[len(points) // 2]) if points else effect


def draw(cls: type[Effect], path: Path) -> None:
    """Write the picture, over time and over strain, in the format that the suffix of `path` says."""
    from matplotlib.figure import Figure

    case = showcase(cls)
    figure = Figure(figsize=(8.0, 2.9), dpi=120, layout="constrained")
    over_time, over_strain = figure.subplots(1, 2, width_ratios=[1.7, 1])
    minutes = case.time_s[-1] > 300
    time = case.time_s / 60 if minutes else case.time_s
    for axis, x in ((over_time, time), (over_strain, 100 * case.strain)):
        if cls.strength:
            axis.plot(x, case.without, color=GREY, lw=1.0, label="without")
        axis.plot(x, case.with_it, color=BLUE, lw=1.1, label=f"with {cls.name.replace('_', ' ')}")
        axis.spines[["top", "right"]].set_visible(False)
        axis.tick_params(labelsize=8)
    over_time.set_xlabel("time / min" if minutes else "time / s", fontsize=8)
    over_time.set_ylabel(case.label, fontsize=8)
    over_strain.set_xlabel("strain / %", fontsize=8)
    figure.legend(
        *over_time.get_legend_handles_labels(), loc="outside upper center", ncols=2, fontsize=8, frameon=False
    )
    with atomic_path(path) as temporary:
        figure.savefig(temporary, format=path.suffix.lower().lstrip("."))
