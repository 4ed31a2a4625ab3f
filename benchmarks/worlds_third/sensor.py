"""One sensor: its laws and sizes, drawn from a seed, and the chain from motion to force and conductance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from simulated_case import laws_of, stream

from worlds_third.laws import FAMILIES, LAW_FAMILIES
from worlds_third.laws.law import Chosen
from worlds_third.randoms import Ranges, Values, draw
from worlds_third.signals import Signals

STAGES = ("kinematics", "mechanics", "pressure", "electrical", "readout")
Hook = tuple[str, Callable[[Signals], None]]  # a stage and what to do to the signals at its end

SIZES: Ranges = {
    "gauge_length_mm": (25.0, 120.0),
    "force_full_N": (5.0, 50.0),
    "resistance_full_ohm": (1e3, 2e6),
    "pretension": (0.01, 0.06),
    "friction": (0.02, 0.12),
    "friction_at_rest": (0.1, 0.5),
    "loops": (0.02, 0.1),
    "drift": (0.01, 0.12),
}
USUAL_STRAIN, ANY_STRAIN = (0.15, 0.6), (0.015, 1.5)
UNUSUAL = 0.4  # share of sensors whose stroke is of any length


@dataclass(frozen=True)
class Sensor:
    """Its numbers, and one law of every family."""

    max_strain: float
    sizes: Values
    loop_sign: float
    drift_sign: float
    laws: Mapping[str, Chosen]

    @property
    def stroke_mm(self) -> float:
        """Displacement at the end of the stroke."""
        return self.max_strain * self.sizes["gauge_length_mm"]

    def told(self) -> dict[str, Any]:
        """For the truth of a case."""
        signs = {"loop_sign": self.loop_sign, "drift_sign": self.drift_sign}
        return {"max_strain": self.max_strain, **self.sizes, **signs, **{k: v.told() for k, v in self.laws.items()}}


def make_sensor(seed: int, asked: str = "", pressed_by_force: bool = False) -> Sensor:
    """Draw a sensor, on wish with some laws only (see `laws_of`), or with contacts that the force presses.

    The laws asked for come first. All else of it stays as it was.
    """
    rng = stream(seed, "sensor")
    drawn = draw(rng, {"max_strain": ANY_STRAIN if rng.uniform() < UNUSUAL else USUAL_STRAIN})
    sizes = draw(rng, SIZES)
    signs = rng.choice([-1.0, 1.0], size=2, p=[0.3, 0.7])
    allowed = laws_of(asked, LAW_FAMILIES)
    if pressed_by_force and "by_force" in allowed["drive"]:
        allowed["drive"] = ["by_force"]
    laws = {family: _chosen(seed, family, names) for family, names in allowed.items()}
    return Sensor(drawn["max_strain"], sizes, float(signs[0]), float(signs[1]), laws)


def _chosen(seed: int, family: str, names: Sequence[str]) -> Chosen:
    rng = stream(seed, "law", family)
    name = names[int(rng.integers(len(names)))]
    law = FAMILIES[family][name]
    return Chosen(name, law, draw(rng, law.ranges))


def respond(sensor: Sensor, s: Signals, hooks: Sequence[Hook] = ()) -> Signals:
    """Fill in strain, force, pressure and ln G, in the order of the physics; hooks act at the end of their stage."""
    laws, sizes = sensor.laws, sensor.sizes
    _act(s, hooks, "kinematics")
    x = s.strain + sizes["pretension"]
    elastic = laws["elasticity"](x, sensor.max_strain)
    rest = sizes["friction_at_rest"]
    friction = sizes["friction"] * (rest + (1.0 - rest) * np.clip(elastic, 0.0, 1.5))
    s.force = elastic + friction * laws["hysteresis"](s.strain, s.step_s)
    _act(s, hooks, "mechanics")
    s.pressure = laws["drive"](s.force, x)
    _act(s, hooks, "pressure")
    drift = laws["drift_place"](laws["drift"](s.strain, s.step_s), s.pressure)
    s.log_g = laws["conductance"](s.pressure, x) + sensor.drift_sign * sizes["drift"] * drift
    s.log_g = s.log_g + sensor.loop_sign * sizes["loops"] * laws["loops"](s.strain)
    _act(s, hooks, "electrical")
    _act(s, hooks, "readout")
    return s


def _act(s: Signals, hooks: Sequence[Hook], stage: str) -> None:
    for at, act in hooks:
        if at == stage:
            act(s)
