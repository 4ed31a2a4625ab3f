"""The next experiment: which designed protocol separates two hypotheses best, after each did its best to imitate.

For each protocol one rival is taken as the truth and simulated; the other's parameters move as far as their priors
let them to imitate it; what remains, over the noise, is what the experiment would show. Both ways, and the smaller
counts. A rival that has all effects of another, and more, can imitate that one on every motion: there one way counts,
with the larger one as the truth. This is discrimination between models in the sense of Atkinson & Fedorov,
Biometrika 62 (1975) 57: the design that leaves the most misfit to the best-fitting rival.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcode.programs.make import Made
from gcode.support.errors import UserError
from testbench.design.ahead import planned
from testbench.design.imitation import Imitation, Noise, Rival, imitate
from testbench.design.protocols import Bounds, drivable

# Kass & Raftery, J. Am. Statist. Assoc. 90 (1995) 773: twice the log odds of 2, 6 and 10.
GRADES = ((1.0, "cannot tell"), (3.0, "a hint"), (5.0, "strong"), (np.inf, "decisive"))


@dataclass(frozen=True)
class Option:
    """One protocol and how well it separates the rivals.

    Attributes
    ----------
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
        If two rivals are the same, or no protocol keeps the limits.
    """
    _check(rivals, noise)
    pairs = [pair for pair in itertools.permutations(rivals, 2) if not _is_case_of(*pair)]
    options = []
    for name, made in drivable(bounds, seed).items():
        if progress:
            progress(f"imitating on {name}")
        ahead = planned(made.trajectory, bounds.gauge_length_mm, tuple(noise), temperature)
        imitations = [imitate(*pair, ahead, noise) for pair in pairs]
        options.append(Option(name, made, min(imitations, key=lambda one: one.log_odds)))
    if not options:
        raise UserError(
            "no designed protocol can be driven within these limits; raise that of speed or of acceleration"
        )
    return sorted(options, key=lambda option: -option.hardest.log_odds)


def _is_case_of(truth: Rival, imitator: Rival) -> bool:
    """Whether a rival is another one without some of its effects: that one is then never told wrong."""
    few, many = ({(name, one.name) for name, one in rival.model.effects.items()} for rival in (truth, imitator))
    return few < many


def _check(rivals: Sequence[Rival], noise: Noise) -> None:
    for one, other in itertools.combinations(rivals, 2):
        if one.model.to_dict() == other.model.to_dict():
            raise UserError(f"{one.name} and {other.name} are the same model; give two rival hypotheses")
    if not noise or not all(np.isfinite(value) and value > 0 for value in noise.values()):
        raise UserError("the models know no noise floor; fit them on a recording with `testbench fit`")
