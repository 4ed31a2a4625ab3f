"""The chain from commanded strain to what is read, with hidden effects at their stages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.worlds.base import BaseWorld

STAGES = ("kinematics", "mechanics", "pressure", "electrical", "readout")


@dataclass(frozen=True)
class Usual:
    """Range of the sensor without any effect, in the calibration recording.

    Attributes
    ----------
    force, ln_g : tuple of float
        Least and largest force [N] and ln of conductance [S].
    """

    force: tuple[float, float] = (0.0, 1.0)
    ln_g: tuple[float, float] = (0.0, 1.0)
    mean_ln_g: float = 0.0


@dataclass
class Scene:
    """One recording in the making; each stage may replace the signals that it owns.

    Attributes
    ----------
    t, commanded : ndarray, shape (n,)
        Time [s] and strain that the tester was told (and reports).
    ambient : ndarray, shape (n,)
        Ambient temperature above its value at the start [K].
    top_N : float
        Force of the base world at 30 % strain: the scale of everything in newtons.
    usual : Usual
        What force and ln G of this sensor usually are: converters and contacts have one range, whatever the motion.
    seed : tuple of int
        For effects with events of their own: the same events at every magnitude.
    e, force, pressing, ln_g : ndarray, shape (n,)
        Strain that the knit sees, force [N], contact force [N], ln of conductance [S].
    """

    t: FloatArray
    commanded: FloatArray
    ambient: FloatArray
    top_N: float
    usual: Usual
    seed: tuple[int, ...]
    e: FloatArray = field(default_factory=lambda: np.empty(0))
    force: FloatArray = field(default_factory=lambda: np.empty(0))
    pressing: FloatArray = field(default_factory=lambda: np.empty(0))
    ln_g: FloatArray = field(default_factory=lambda: np.empty(0))

    def rng(self) -> np.random.Generator:
        """A fresh generator, the same at each call."""
        return np.random.default_rng(list(self.seed))

    def rate(self) -> FloatArray:
        """Strain rate of the knit [1/s]."""
        return np.gradient(self.e, self.t)

    def path(self) -> FloatArray:
        """Sum of all strain travelled so far, back and forth."""
        return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(self.e)))])


Shape = Mapping[str, float]  # parameters of a form but its magnitude
Change = Callable[[Scene, float, Shape], None]


@dataclass(frozen=True)
class Form:
    """One way in which an effect may show.

    Attributes
    ----------
    effect, name : str
        The mechanism, and the law that it follows here.
    changes : mapping of stage to function
        ``change(scene, magnitude, shape)`` replaces signals of the scene; magnitude 0 must leave them as they are.
    ranges : mapping
        Shape parameters: (low, high), or a list to choose from.
    most : float
        Largest magnitude that is still plausible.
    """

    effect: str
    name: str
    changes: Mapping[str, Change]
    ranges: Mapping[str, tuple[float, float] | list[float]]
    most: float

    def draw(self, rng: np.random.Generator) -> dict[str, float]:
        """Shape parameters; wide positive ranges are drawn evenly in their logarithm."""
        return {name: _draw(limits, rng) for name, limits in self.ranges.items()}


def _draw(limits: tuple[float, float] | list[float], rng: np.random.Generator) -> float:
    if isinstance(limits, list):
        return float(rng.choice(limits))
    low, high = limits
    if low > 0 and high / low >= 4:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))
    return float(rng.uniform(low, high))


@dataclass(frozen=True)
class Hidden:
    """A form with its shape and its magnitude."""

    form: Form
    shape: Shape
    magnitude: float


def run(base: BaseWorld, scene: Scene, hidden: Sequence[Hidden] = ()) -> tuple[FloatArray, FloatArray]:
    """Force [N] and ln conductance [ln S] as read without noise, shape (n,) each."""
    scene.e = scene.commanded
    _apply("kinematics", scene, hidden)
    scene.force = base.force(scene.e)
    _apply("mechanics", scene, hidden)
    scene.pressing = scene.force
    _apply("pressure", scene, hidden)
    scene.ln_g = base.contact(scene.pressing, scene.e)
    _apply("electrical", scene, hidden)
    scene.ln_g = scene.ln_g + base.drift(scene.t)
    _apply("readout", scene, hidden)
    return scene.force, scene.ln_g


def _apply(stage: str, scene: Scene, hidden: Sequence[Hidden]) -> None:
    for one in hidden:
        change = one.form.changes.get(stage)
        if change is not None and one.magnitude != 0:
            change(scene, one.magnitude, one.shape)
