"""The next experiment: which designed protocol separates two hypotheses best, after each did its best to imitate.

For each protocol one rival is taken as the truth and simulated; the other's parameters move as far as their priors
let them to imitate it; what remains, over the noise, is what the experiment would show. Both ways, and the smaller
counts. This is discrimination between models in the sense of Atkinson & Fedorov, Biometrika 62 (1975) 57: the design
that leaves the most misfit to the best-fitting rival.
"""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcode.programs.make import Made, make
from gcode.support.errors import UserError
from gcode.trajectories.trajectory import Trajectory
from testbench.design.imitation import imitate
from testbench.design.protocols import NOISE, Bounds, menu
from testbench.fitting.evidence.likelihood import independent_share
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel, inputs
from testbench.measurements.measurement import BURN_IN_S, Measurement
from testbench.recordings.channels import DISPLACEMENT
from testbench.recordings.recording import Recording

SHORTLIST = 4  # protocols on which the imitation is driven to its end, beside the noise
SHARES = (1.0, 0.9, 0.75, 0.5)  # of the limits that a design uses
FIRST_ITERATIONS, LAST_ITERATIONS = 12, 40
ROOM_C, SWING_K, SWING_S = 23.0, 1.0, 1500.0  # a room with a thermostat, where the temperature is measured
# Kass & Raftery, J. Am. Statist. Assoc. 90 (1995) 773: twice the log odds of 2, 6 and 10.
GRADES = ((1.0, "cannot tell"), (3.0, "a hint"), (5.0, "strong"), (np.inf, "decisive"))

Noise = Mapping[str, float]


@dataclass(frozen=True)
class Rival:
    """One hypothesis: a fitted model under a short name."""

    name: str
    model: KnitModel


@dataclass(frozen=True)
class Imitation:
    """What remains of one rival when another has imitated it.

    Attributes
    ----------
    truth, imitator : str
        Names of the rivals.
    left : dict of channel to ndarray, shape (n,)
        Truth minus imitation over the noise floor, from the burn-in on.
    independent_share : float
        Independent samples per sample of `left`.
    """

    truth: str
    imitator: str
    left: Mapping[str, FloatArray]
    independent_share: float

    @property
    def noise_units(self) -> float:
        """RMS of what remains over the noise floor, in the channel where it is largest."""
        return max(float(np.sqrt(np.mean(values**2))) for values in self.left.values())

    @property
    def log_odds(self) -> float:
        """Expected log-likelihood ratio for the truth, with the residual's autocorrelation allowed for."""
        return 0.5 * self.independent_share * sum(float(np.sum(values**2)) for values in self.left.values())

    @property
    def channel(self) -> str:
        """The channel that shows it best."""
        return max(self.left, key=lambda one: float(np.sum(self.left[one] ** 2)))


@dataclass(frozen=True)
class Option:
    """One protocol and how well it separates the rivals.

    Attributes
    ----------
    name : str
    made : Made
        Its checked program.
    hardest : Imitation
        Of all pairs and both ways, the one that remains hardest to tell.
    """

    name: str
    made: Made
    hardest: Imitation

    @property
    def grade(self) -> str:
        """A plain word on how decisive it will be."""
        return next(word for limit, word in GRADES if self.hardest.log_odds < limit)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form."""
        return {
            "protocol": self.name,
            "duration_s": self.made.trajectory.duration_s,
            "noise_units": self.hardest.noise_units,
            "log_odds": self.hardest.log_odds,
            "grade": self.grade,
            "channel": self.hardest.channel,
            "truth": self.hardest.truth,
            "imitator": self.hardest.imitator,
        }


def propose(
    rivals: Sequence[Rival],
    noise: Noise,
    bounds: Bounds,
    seed: int = 1,
    temperature: bool = False,
    progress: Callable[[str], None] | None = None,
) -> list[Option]:
    """Rank the designed protocols by how well they separate the rivals, the best first.

    Parameters
    ----------
    rivals : sequence of Rival
        Two or more; with more, the pair that is hardest to tell decides.
    noise : mapping of channel to float
        What a fit leaves anyway of ``force`` in N, of ``conductance`` in ln S; only these channels are looked at.
    bounds : Bounds
        Limits of the machine and the sensor, duration, gauge length.
    seed : int
        Of the random protocols.
    temperature : bool
        The temperature will be measured: a swing of the room by 1 K is assumed.
    progress : callable, optional
        Called with a short text at each protocol.

    Raises
    ------
    UserError
        If the rivals are fewer than two or the same, or no protocol keeps the limits.
    """
    _check(rivals, noise)
    tell = progress or (lambda _text: None)
    stages = _stages(bounds, seed, noise, temperature)
    options = {}
    for stage in stages:
        tell(f"imitating on {stage.name}")
        options[stage.name] = stage.option(rivals, FIRST_ITERATIONS)
    ranked = sorted(stages, key=lambda stage: -options[stage.name].hardest.log_odds)
    for stage in ranked[:SHORTLIST] + [stage for stage in ranked[SHORTLIST:] if stage.name == NOISE]:
        tell(f"imitating on {stage.name} to the end")
        options[stage.name] = stage.option(rivals, LAST_ITERATIONS)
    return sorted(options.values(), key=lambda option: -option.hardest.log_odds)


def _stages(bounds: Bounds, seed: int, noise: Noise, temperature: bool) -> list[_Stage]:
    stages = []
    for name, made in drivable(bounds, seed).items():
        measurement = planned(made.trajectory, bounds.gauge_length_mm, tuple(noise), temperature)
        stages.append(_Stage(name, made, measurement, noise))
    if not stages:
        raise UserError("no designed protocol can be driven within these limits; raise --v-max or --a-max")
    return stages


def drivable(bounds: Bounds, seed: int) -> dict[str, Made]:
    """Every protocol whose program passes its own check, designed for as much of the limits as it can use."""
    found: dict[str, Made] = {}
    for share in SHARES:
        for name, spec in menu(bounds, share).items():
            if name not in found:
                # A design that cannot be executed within the limits is tried again with more room to them.
                with contextlib.suppress(UserError):
                    found[name] = make(spec, seed, bounds.gauge_length_mm)
    return found


def _check(rivals: Sequence[Rival], noise: Noise) -> None:
    if len(rivals) < 2:
        raise UserError(f"an experiment needs at least two rival models, got {len(rivals)}")
    for one, other in itertools.combinations(rivals, 2):
        if one.model.to_dict() == other.model.to_dict():
            raise UserError(f"{one.name} and {other.name} are the same model; give two rival hypotheses")
    if not noise or not all(np.isfinite(value) and value > 0 for value in noise.values()):
        raise UserError("the models know no noise floor; fit them on a recording with `testbench fit`")


class _Stage:
    """One protocol, simulated."""

    def __init__(self, name: str, made: Made, measurement: Measurement, noise: Noise) -> None:
        self.name, self.made, self.measurement, self.noise = name, made, measurement, noise
        self._reached: dict[tuple[str, str], KnitModel] = {}

    def option(self, rivals: Sequence[Rival], iterations: int) -> Option:
        """Let every rival imitate every other on one protocol; the pair that is hardest to tell apart."""
        found = [
            self._imitation(truth, imitator, iterations) for truth, imitator in itertools.permutations(rivals, 2)
        ]
        hardest = min(found, key=lambda one: one.log_odds)
        return Option(self.name, self.made, hardest)

    def _imitation(self, truth: Rival, imitator: Rival, iterations: int) -> Imitation:
        clean = self.measurement.modelled(truth.model)
        start = self._reached.get((truth.name, imitator.name), imitator.model)
        closest, left = imitate(start, self.measurement, clean, self.noise, iterations)
        self._reached[truth.name, imitator.name] = closest
        return Imitation(truth.name, imitator.name, left, independent_share(self.measurement))


def planned(
    trajectory: Trajectory, gauge_length_mm: float, channels: Sequence[str], temperature: bool = False
) -> Measurement:
    """A measurement that was not made yet: the motion, and empty channels."""
    time_s, position_mm = trajectory.time_s, trajectory.position_mm
    room = ROOM_C + SWING_K * np.sin(2 * np.pi * time_s / SWING_S) if temperature else None
    recording = Recording(time_s, {DISPLACEMENT: position_mm}, gauge_length_mm, "planned experiment")
    signals = inputs(time_s, position_mm / gauge_length_mm, room)
    empty = {channel: np.zeros(len(time_s)) for channel in channels}
    return Measurement(signals, 1 / trajectory.rate_hz, empty, time_s >= BURN_IN_S, recording, np.zeros(len(time_s)))
