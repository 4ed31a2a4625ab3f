"""A small picture of what an effect does: the same motion without and with it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gcode.support.colours import BLUE, GREY
from gcode.support.figures import PRINT
from gcode.support.files import atomic_path
from testbench.knit.catalogue import baseline
from testbench.knit.effect import Effect, FloatArray, Signals, Stage
from testbench.knit.model import KnitModel, inputs

DT_S = 0.05
VISIBLE, MOST_RAISES = 0.15, 15  # wanted change of the curve, as a share of its span; steps towards it


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
    times = [value for key, value in effect if key.endswith("_s") and key != "when_s" and isinstance(value, float)]
    return max(times, default=0.0) > 50 or effect.name in ("drift", "drift_power", "temperature_drift_trend")


def showcase(cls: type[Effect]) -> Showcase:
    """Simulate the showcase of one effect, its strength raised until it can be seen."""
    effect = cls()
    time_s, strain = motion(60.0 if slow(effect) else 5.0)
    model = baseline().without("drift") if cls.stage is Stage.ELECTRICAL else baseline()
    has_namesake = effect.name in model and bool(effect.strength)
    without = _curves(model.without(effect.name) if has_namesake else model, time_s, strain)
    key = "force_N" if "force_N" in effect.writes or cls.stage is Stage.KINEMATICS else "conductance_S"
    scale, label = (1.0, "force (N)") if key == "force_N" else (1e6, "conductance (µS)")
    effect = _midway(effect, _curves(model, time_s, strain)) if effect.nonlinear else effect
    with_it = _curves(model + effect, time_s, strain)[key]
    for _ in range(MOST_RAISES):
        raised = _raised(effect)
        if raised == effect or np.max(np.abs(with_it - without[key])) > VISIBLE * np.ptp(without[key]):
            break
        effect, with_it = raised, _curves(model + raised, time_s, strain)[key]
    return Showcase(time_s, strain, scale * without[key], scale * with_it, label, effect)


def _curves(model: KnitModel, time_s: FloatArray, strain: FloatArray) -> dict[str, FloatArray]:
    return model.simulate(inputs(time_s, strain, 23 + 2 * np.sin(time_s / time_s[-1] * 6)), DT_S)


def _raised(effect: Effect) -> Effect:
    """The effect with a strength 1.6 times as large, as far as its bounds go; weights begin as a wave."""
    if not effect.strength:
        return effect
    strength = getattr(effect, effect.strength)
    if isinstance(strength, float):
        return effect.near(**{effect.strength: 1.6 * strength})
    wave = 0.01 * np.sin(np.linspace(1, 6, len(strength)))
    return effect.near(**{effect.strength: tuple(1.6 * np.array(strength) if any(strength) else wave)})


def _midway(effect: Effect, signals: Signals) -> Effect:
    """The effect in the middle of its starts on these signals, where its level or limit is reached."""
    points = effect.starting_points(signals, {})
    middle = points[len(points) // 2] if points else {}
    return effect.near(**{key: value for key, value in middle.items() if key != effect.strength})


def draw(cls: type[Effect], path: Path) -> None:
    """Write the picture, over time and over strain, in the format that the suffix of `path` says."""
    from matplotlib import rc_context
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
    over_time.set_xlabel("time (min)" if minutes else "time (s)", fontsize=8)
    over_time.set_ylabel(case.label, fontsize=8)
    over_strain.set_xlabel("strain (%)", fontsize=8)
    figure.legend(
        *over_time.get_legend_handles_labels(), loc="outside upper center", ncols=2, fontsize=8, frameon=False
    )
    with rc_context(PRINT), atomic_path(path) as temporary:
        figure.savefig(temporary, format=path.suffix.lower().lstrip("."))
