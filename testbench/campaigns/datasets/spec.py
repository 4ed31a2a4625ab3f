"""The TOML file of a data set: what it may say, and what it means."""

from __future__ import annotations

import re
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, field_validator, model_validator

from gcode.support.strict import StrictModel, read_toml, validated
from testbench.recordings.instruments import Instruments
from testbench.rig.simulation.played import DEFAULT_REST_S, LONGEST_REST_S

MOST_CAMPAIGNS = 1_000_000
Seed = Annotated[int, Field(ge=0, lt=1 << 63, strict=True)]
Seeds = Annotated[tuple[Seed, ...], Field(min_length=1, max_length=MOST_CAMPAIGNS)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Rest = Annotated[float, Field(ge=0, le=LONGEST_REST_S, allow_inf_nan=False)]
Range = tuple[float, float]


class _Seeded(StrictModel):
    """A table whose seeds may be a list or a range such as ``"1-500"``."""

    @model_validator(mode="before")
    @classmethod
    def _ranges(cls, data: Any) -> Any:
        if not isinstance(data, dict) or not isinstance(data.get("seeds"), str):
            return data
        match = re.fullmatch(r"(\d{1,18})-(\d{1,18})", data["seeds"].strip())
        if match is None or int(match[1]) > int(match[2]):
            raise ValueError(f'seeds must be a list or a range like "1-500", got {data["seeds"][:60]!r}')
        first, last = int(match[1]), int(match[2])
        if last - first >= MOST_CAMPAIGNS:
            raise ValueError(f"seeds must be at most {MOST_CAMPAIGNS}, got {last - first + 1}")
        return {**data, "seeds": tuple(range(first, last + 1))}


class TrajectoryWish(_Seeded):
    """Programs to be planned: a preset of `gcode` or a spec file, once for each seed."""

    preset: str | None = None
    spec: str | None = None
    seeds: Seeds
    duration_s: Positive | None = None

    @model_validator(mode="after")
    def _one_source(self) -> TrajectoryWish:
        if (self.preset is None) == (self.spec is None):
            raise ValueError("give either preset or spec")
        return self


class DatasetSpec(_Seeded):
    """What a data set holds.

    Attributes
    ----------
    sensors : tuple of str
        Presets, or model files relative to the spec.
    seeds : tuple of int
        Of the rig; ``"1-500"`` is a range.
    programs : tuple of str
        Mach4 programs relative to the spec; ``*`` is allowed.
    trajectory : TrajectoryWish
        Instead of `programs`.
    gauge_length_mm : float
    instruments : Instruments
    effects : str, optional
        Python file with effects of your own, relative to the spec.
    same_sensor : bool
        The programs are run one after another on one sensor, which remembers; otherwise each on a sensor that has
        never been stretched.
    rest_s : float
        Rest between them.
    vary : dict of str to (low, high)
        ``effect.parameter``: drawn uniformly for each campaign, by its seed.
    """

    sensors: tuple[str, ...] = Field(min_length=1)
    seeds: Seeds
    programs: tuple[str, ...] = ()
    trajectory: TrajectoryWish | None = None
    gauge_length_mm: Positive = 25.0
    instruments: Instruments = Instruments()
    effects: str | None = None
    same_sensor: bool = False
    rest_s: Rest = DEFAULT_REST_S
    vary: dict[str, Range] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _agrees(self) -> DatasetSpec:
        if bool(self.programs) == (self.trajectory is not None):
            raise ValueError("give either programs or a table [trajectory]")
        if "rest_s" in self.model_fields_set and not self.same_sensor:
            raise ValueError("rest_s is between programs on one sensor; it needs same_sensor = true")
        return self

    @field_validator("vary")
    @classmethod
    def _ranges_rise(cls, vary: dict[str, Range]) -> dict[str, Range]:
        for address, (low, high) in vary.items():
            if not low <= high or not isfinite(high - low):
                raise ValueError(f"{address} must be [low, high], finite and low first, got [{low:g}, {high:g}]")
        return vary


def read_spec(path: Path) -> DatasetSpec:
    """Read a data set's TOML file.

    Raises
    ------
    UserError
        If it is not TOML, or an entry is wrong; the message names it.
    """
    return validated(read_toml(path), DatasetSpec, path, "spec")
