"""The file that an investigation is kept in: what was asked, and every run with what was believed after it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field, model_validator

from gcode.support.errors import UserError
from gcode.support.files import write_json
from gcode.support.strict import NamedModel, StrictModel, load
from testbench.design.forecast import Likely, Reading
from testbench.design.protocols import Bounds, bounds_with, menu
from testbench.knit.catalogue import Catalogue, model_from_dict
from testbench.measurements.responses import UNIT_OF
from testbench.recordings.stored import GaugeLength, Label, Remark, Sha256, checked_model

NAME = "investigation.json"
MOST_RUNS = 200
SURE, SPENT = "sure", "the time is spent"

Positive = Annotated[float, Field(gt=0, le=1e9)]
Chance = Annotated[float, Field(ge=0, le=1 + 1e-9)]
Noise = Annotated[float, Field(ge=1e-12, le=1e9)]  # N or ln S
Rest = Annotated[float, Field(ge=0, le=1e9)]  # s; of an investigation that went on after weeks, too
Seconds = Annotated[float, Field(gt=0, le=2 * 24 * 3600)]


class Settings(NamedModel, StrictModel):
    """What was asked for.

    Attributes
    ----------
    bounds : mapping
        Fields of `testbench.Bounds`; ``duration_s`` is that of one run.
    budget_s : float
        Time of motion to spend at most.
    sure : float
        Probability at which it ends.
    specimen : {"aged", "fresh"}
        The same specimen all along, or a new one for each run.
    motion : {"designed", "perlin"}
        ``perlin``: random motion all along, to compare with.
    rest_s : float
        Rest of an aged specimen before each run but the first.
    seed : int
        Of noise and random motion.
    trials : int
        Motions that a design weighs beside the named protocols.
    effects_at_most : int
        Effects that a diagnosis puts in at most.
    max_force_N : float or None
        More force than that no likely hypothesis may expect, and no recording may go on with.
    effects_sha256 : str or None
        Of the file with effects of the user's own.
    own_effects : list of str or None
        Their names, from a file or not; None: an older version kept none.
    strain_allowed_percent : float or None
        What the force has allowed so far, where it has passed its limit once; no motion goes beyond it.
    """

    model_config = ConfigDict(title="investigate")  # errors name who takes these

    bounds: dict[Label, Positive]
    budget_s: float
    sure: float = Field(0.95, gt=0.5, lt=1)
    specimen: Literal["aged", "fresh"] = "aged"
    motion: Literal["designed", "perlin"] = "designed"
    rest_s: Rest = 30.0
    seed: int = Field(1, ge=0, lt=2**31)
    trials: int = Field(24, ge=1, le=10_000)
    effects_at_most: int = Field(1, ge=1)
    max_force_N: Positive | None = None
    gauge_length_mm: GaugeLength = 25.0
    effects_sha256: Sha256 | None = None
    own_effects: list[Label] | None = Field(None, max_length=1000)
    strain_allowed_percent: Positive | None = None

    @model_validator(mode="after")
    def _some_runs(self) -> Settings:
        menu(self.limits)  # refuses limits that no run can keep
        run_s = self.limits.duration_s
        if not run_s <= self.budget_s <= MOST_RUNS * run_s:
            few = self.budget_s < run_s
            bound = "are less than one run" if few else f"are more than {MOST_RUNS} runs"
            raise ValueError(f"budget_minutes: {self.budget_s / 60:g} min {bound} of {run_s / 60:g} min")
        return self

    @property
    def limits(self) -> Bounds:
        """As the design needs them."""
        asked = bounds_with(self.bounds, self.gauge_length_mm)
        allowed = self.strain_allowed_percent or asked.strain_max_percent
        return replace(asked, strain_max_percent=min(asked.strain_max_percent, allowed))


class LikelyState(StrictModel):
    """A hypothesis that was still likely, with its model as JSON."""

    name: Label
    chance: Chance
    model: Annotated[dict[str, Any], AfterValidator(lambda data: checked_model(data, "model"))]
    scales: dict[Label, Annotated[float, Field(ge=1e-12, le=1e12)]]


class BeliefState(StrictModel):
    """What was believed after a run.

    Attributes
    ----------
    probabilities : mapping
        Of ``nothing``, ``unknown`` and every mechanism; they sum to 1.
    own : mapping
        What the evidence says of this run's recording alone, where each run has a fresh specimen; else of all.
    noise : mapping
        What the best model leaves in each channel, in N or in ln S.
    pieces : float
        Independent pieces of one recording, at most.
    likely : list
        The models of what is still likely, the most probable first; two at least where two were fitted.
    """

    probabilities: dict[Label, Chance] = Field(min_length=1, max_length=1000)
    own: dict[Label, Chance] = Field(min_length=1, max_length=1000)
    verdict: Literal["missing", "nothing_missing", "unknown"]
    noise: dict[str, Noise] = Field(min_length=1)
    pieces: Positive
    likely: list[LikelyState] = Field(max_length=100)

    @model_validator(mode="after")
    def _agrees_with_itself(self) -> BeliefState:
        if strange := [one.name for one in self.likely if one.name not in self.probabilities]:
            raise ValueError(f"likely: {strange[0]!r} has no probability")
        if strange := sorted(set(self.noise) - set(UNIT_OF)):
            raise ValueError(f"noise: channels are {', '.join(UNIT_OF)}, got {strange[0]!r}")
        return self

    @property
    def top(self) -> tuple[str, float]:
        """The most probable hypothesis and its probability."""
        return max(self.probabilities.items(), key=lambda one: one[1])

    def told_as(self, probabilities: dict[str, float]) -> BeliefState:
        """The same with other probabilities: those of all recordings, less what is doubted in them."""
        likely = [one.model_copy(update={"chance": probabilities[one.name]}) for one in self.likely]
        return self.model_copy(update={"probabilities": probabilities, "likely": likely})

    def rivals(self, catalogue: Catalogue, source: str) -> list[Likely]:
        """The models of what is still likely."""
        return [
            Likely(one.name, self.probabilities[one.name], model_from_dict(one.model, catalogue, source), one.scales)
            for one in self.likely
        ]

    @property
    def reading(self) -> Reading:
        """How much the next recording will count."""
        return Reading(self.noise, self.pieces)


class RunState(StrictModel):
    """One run: planned, then recorded, then judged.

    Attributes
    ----------
    words : str
        The motion, for people.
    seconds : float
        Length of the motion.
    rest_s : float or None
        Rest before it; None for a fresh specimen. Known once it was recorded.
    expected_nats, perlin_nats : float or None
        What it was expected to tell, and what random motion would have; None where it was not designed.
    begun_s, ended_s : float or None
        When it was first begun, and ended, by the clock.
    """

    words: Remark
    seconds: Seconds
    rest_s: Rest | None = None
    expected_nats: float | None = None
    perlin_nats: float | None = None
    recorded: bool = False
    begun_s: Annotated[float, Field(ge=0, le=1e12)] | None = None
    ended_s: Annotated[float, Field(ge=0, le=1e12)] | None = None
    belief: BeliefState | None = None

    @model_validator(mode="after")
    def _in_turn(self) -> RunState:
        if self.belief is not None and not self.recorded:
            raise ValueError("belief: a run is recorded before it is judged")
        return self


class Investigation(StrictModel):
    """An investigation as it is kept."""

    format: Literal["knitbench-investigation"] = "knitbench-investigation"
    version: Literal[1] = 1
    sensor: str = Field("", max_length=500)
    settings: Settings
    runs: list[RunState] = Field([], max_length=2 * MOST_RUNS)  # a motion may be shorter than a run may take
    ended: Literal["", "sure", "the time is spent"] = ""

    @model_validator(mode="after")
    def _one_run_after_the_other(self) -> Investigation:
        if any(run.belief is None for run in self.runs[:-1]):
            raise ValueError("runs: only the last one may be without a belief")
        return self

    @property
    def spent_s(self) -> float:
        """Time of motion so far."""
        return sum(run.seconds for run in self.runs if run.recorded)

    @property
    def judged_s(self) -> float:
        """Time of motion that the last belief rests on."""
        return sum(run.seconds for run in self.runs if run.belief is not None)

    @property
    def belief(self) -> BeliefState | None:
        """The last one."""
        return next((run.belief for run in reversed(self.runs) if run.belief is not None), None)


def load_investigation(folder: str | Path) -> Investigation:
    """The investigation that is kept in `folder`.

    Raises
    ------
    UserError
        If there is none, or the file is damaged.
    """
    path = Path(folder) / NAME
    if not path.is_file():
        raise UserError(f"{folder}: no investigation in this folder ({NAME} is missing); begin one there")
    return load(path, Investigation, "investigation")


def save_investigation(folder: Path, investigation: Investigation) -> None:
    """Write it atomically: a kill leaves the old file or the new one."""
    write_json(folder / NAME, investigation.model_dump(mode="json"))


def go_on(folder: Path, budget_minutes: float | None = None, sure: float | None = None) -> None:
    """Let an investigation spend other minutes or be otherwise sure from here on; one that had ended goes on for it.

    Raises
    ------
    UserError
        If there is none, or it cannot be asked for that.
    """
    state = load_investigation(folder)
    said = {"budget_s": None if budget_minutes is None else 60 * budget_minutes, "sure": sure}
    asked = state.settings.model_dump() | {name: value for name, value in said.items() if value is not None}
    settings = Settings(**asked)
    if settings != state.settings:
        save_investigation(folder, state.model_copy(update={"settings": settings, "ended": ""}))


def program_folder(folder: Path, number: int) -> Path:
    """Where the program of a run is, counted from 1."""
    return folder / f"plan-{number}"


def run_folder(folder: Path, number: int) -> Path:
    """The campaign of a run."""
    return folder / f"run-{number}"
