"""The motion that is expected to tell most: named protocols, random motions, and neighbours of the best.

What a motion tells is the mutual information between hypothesis and recording (`testbench.design.information`). The
search climbs its lower bound: it makes the conditional entropy, what may stay open, as small as it can.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gcode.programs.make import Made, make
from gcode.support.errors import UserError
from testbench.design.ahead import following
from testbench.design.compositions import Motion, drawn, in_words, motion_of, varied
from testbench.design.forecast import Forecaster, Likely, Reading
from testbench.design.information import Information, information
from testbench.design.protocols import NOISE, Bounds, drivable
from testbench.measurements.coarser import coarser
from testbench.measurements.measurement import Measurement

DESIGN_HZ = 5.0  # grid of the predictions
BEST = 3  # motions whose neighbours are tried
BY_CHANCE = 0.5  # of the trials; the rest are neighbours
LEAST_WEIGHT = 0.02  # of a hypothesis: what is nearly excluded still has to be told from


@dataclass(frozen=True, eq=False)
class Design:
    """The motion to make next.

    Attributes
    ----------
    name : str
        ``designed``, or a named protocol that no composition beat.
    made : Made
        Its checked program.
    expected, perlin : Information
        What it is expected to tell, and what random motion of the same length would.
    tried : int
        Motions that were weighed.
    """

    name: str
    made: Made
    expected: Information
    perlin: Information
    tried: int

    @property
    def words(self) -> str:
        """The motion in words."""
        return in_words(self.made.spec) if self.name == "designed" else self.name.replace("-", " ")


def best_motion(
    likely: Sequence[Likely],
    measurement: Measurement,
    reading: Reading,
    bounds: Bounds,
    seed: int = 1,
    rest_s: float | None = None,
    trials: int = 40,
    max_force_N: float = float("inf"),
    progress: Callable[[str], None] | None = None,
) -> Design:
    """Find the motion within the bounds that is expected to tell most.

    Parameters
    ----------
    likely : sequence of Likely
        Two or more hypotheses, fitted to `measurement`.
    measurement : Measurement
        All readings so far.
    reading : Reading
        How much a recording counts.
    bounds : Bounds
        Limits and length of the motion.
    seed : int
        Of the motions that are tried.
    rest_s : float, optional
        The same specimen goes on after this rest; None: a fresh one.
    trials : int
        Motions to weigh beside the named ones.
    max_force_N : float
        No hypothesis may expect more force.
    progress : callable, optional
        Called with a short text at each step.

    Raises
    ------
    UserError
        If the hypotheses are fewer than two, or no motion keeps the limits.
    """
    if len(likely) < 2:
        raise UserError(f"a motion that separates needs two hypotheses or more, got {len(likely)}")
    tell = progress or (lambda _text: None)
    tell("linearising what is still likely")
    history = coarser(measurement, DESIGN_HZ)
    forecasters = [Forecaster(one, history, reading) for one in likely]
    probabilities = [max(one.probability, LEAST_WEIGHT) for one in likely]
    rng = np.random.default_rng(seed)
    found: list[_Weighed] = []

    def weigh(name: str, motion: Motion) -> None:
        ahead = following(history, motion.trajectory, bounds.gauge_length_mm, rest_s)
        predictions, tops_N = zip(*(one.expect(ahead) for one in forecasters), strict=True)
        is_finite = all(np.isfinite(p.mean).all() and np.isfinite(p.factor).all() for p in predictions)
        if is_finite and not any(top_N > max_force_N for top_N in tops_N):
            told = information(predictions, probabilities)
            found.append(_Weighed(name, motion, told))
            tell(f"motion {len(found)} tells {told.low:.3f} nats ({name})")

    for name, made in drivable(bounds, seed).items():
        weigh(name, Motion((), made.spec, made.trajectory))
    by_chance = max(int(BY_CHANCE * trials), 1)
    for number in range(trials):
        free = sorted((w for w in found if w.motion.genes), key=lambda w: w.told.conditional_entropy)[:BEST]
        genes = drawn(rng) if number < by_chance or not free else varied(free[number % len(free)].motion.genes, rng)
        if motion := motion_of(genes, bounds, seed):
            weigh("designed", motion)
    perlin = next((w.told for w in found if w.name == NOISE), Information(0.0, 0.0, float("nan")))
    for one in sorted(found, key=lambda w: w.told.conditional_entropy):
        with contextlib.suppress(UserError):  # the controller's deviations may pass a limit that the plan keeps
            made = make(one.motion.spec, seed, bounds.gauge_length_mm)
            return Design(one.name, made, one.told, perlin, len(found))
    raise UserError("no motion keeps these limits; allow more speed, acceleration, force or time")


@dataclass(frozen=True, eq=False)
class _Weighed:
    name: str
    motion: Motion
    told: Information
