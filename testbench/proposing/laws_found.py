"""What is found: laws that were refitted, and the whole of a proposal."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Literal

from testbench.knit.effect import FloatArray
from testbench.knit.effect_names import check_name
from testbench.measurements.measurement import Measurement
from testbench.proposing.grids import Grid
from testbench.proposing.laws.law import Law
from testbench.results.model_file import ModelFile

Verdict = Literal["proposed", "nothing_left", "no_law", "does_not_hold"]


@dataclass(frozen=True)
class Option:
    """A law that was refitted.

    Attributes
    ----------
    law : Law
    log_evidence : float
        ln Z over the model without it, in nats.
    holds, chosen : float
        Shares of resampled recordings in which it gains, and in which it is the best.
    """

    law: Law
    log_evidence: float
    holds: float
    chosen: float


@dataclass(frozen=True)
class Step:
    """One law found, and what else could be it.

    Attributes
    ----------
    option : Option
    alternatives : tuple of Option
        The other laws that were refitted, the best first.
    tied : int
        How many of them these recordings cannot tell from it.
    dependence : tuple of ndarray
        z at the samples, and what is left of the channel there without and with the law.
    beyond : float
        Share of the held-out recording in which what the law follows lies beyond all that it was fitted on.
    """

    option: Option
    alternatives: tuple[Option, ...]
    tied: int
    dependence: tuple[FloatArray, FloatArray, FloatArray]
    beyond: float = 0.0


@dataclass(frozen=True)
class Proposed:
    """Result of `propose_law`.

    Attributes
    ----------
    verdict : {"proposed", "nothing_left", "no_law", "does_not_hold"}
    name : str
        Of the effect; a second law is called ``NAME_2``.
    steps : tuple of Step
        The laws, in the order in which they were found.
    rejected : Step or None
        What was found on the calibration and does not hold on the held-out recording.
    notes : tuple of str
        What this recording cannot judge.
    before, after : ModelFile
        The ladder up to the wide base, and with the laws.
    error_before, error_after, noise_floor : mapping of channel to float
        Held-out RMS in N and in ln S.
    calibration, held : Measurement
    grid : Grid
    """

    verdict: Verdict
    name: str
    steps: tuple[Step, ...]
    rejected: Step | None
    notes: tuple[str, ...]
    before: ModelFile
    after: ModelFile
    error_before: Mapping[str, float]
    error_after: Mapping[str, float]
    noise_floor: Mapping[str, float]
    calibration: Measurement
    held: Measurement
    grid: Grid

    @property
    def laws(self) -> tuple[tuple[Law, str], ...]:
        """Laws and their names."""
        return tuple((step.option.law, numbered(self.name, k)) for k, step in enumerate(self.steps))


def numbered(name: str, index: int) -> str:
    """Name of law number `index` from 0: the first has the plain name, the others a number behind it."""
    return name if index == 0 else f"{name}_{index + 1}"


def check_names(name: str, source: str, taken: Collection[str], most: int) -> None:
    """Refuse names that the laws, at most so many, cannot have; see `testbench.knit.effect_names.check_name`.

    Raises
    ------
    UserError
        With `source` in front.
    """
    for index in range(most):
        check_name(numbered(name, index), source, taken)
