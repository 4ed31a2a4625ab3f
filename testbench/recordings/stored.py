"""What stored files may say: models, recipes, manifests, lists of campaigns, events. Bounds for each entry.

`gcode.support.strict` reads a file and checks it against one of these; nothing else of it goes any further.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from gcode.support.strict import ExtraIgnored, StrictModel, read_json, validated
from testbench.recordings.checks import LONGEST_GAUGE_MM
from testbench.recordings.instruments import Instruments

# As in testbench.knit.model, not imported: the hidden worlds read recordings and must not know the physics.
MODEL_FORMAT, MODEL_VERSION = "knitbench-model", 1
Sha256 = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
Label = Annotated[str, Field(max_length=500)]
Remark = Annotated[str, Field(max_length=20_000)]
Count = Annotated[int, Field(ge=0, le=1 << 53)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
GaugeLength = Annotated[float, Field(gt=0, le=LONGEST_GAUGE_MM, allow_inf_nan=False)]
# The name of a file beside the manifest: nothing that leads anywhere else.
FILE_NAME = r"^[^./\\\x00-\x1f\x7f][^/\\\x00-\x1f\x7f]{0,199}$"
FileName = Annotated[str, Field(pattern=FILE_NAME)]
MOST_SEEDS = 1 << 64
Seed = Annotated[int, Field(ge=0, lt=MOST_SEEDS)]
Rest = Annotated[float, Field(ge=0, le=1e5)]
Number = float | int | bool | str | None
Origin = Literal["simulated", "recorded", "imported", "aligned"]
Status = Literal[
    "recording", "complete", "interrupted", "alarm", "port lost", "disk full", "disk error"
]  # see docs/recording.md


class StoredEffect(StrictModel):
    """One effect of a stored model; the effect's own class checks its parameters."""

    name: Label
    effect: Label
    parameters: dict[Label, Number | list[Number] | list[list[Number]]]


class StoredModel(ExtraIgnored):
    """A knit model as `KnitModel.to_dict` writes it; what a file adds beside it (a fit, a history) is allowed."""

    format: Label
    version: int
    effects: list[StoredEffect] = Field(max_length=200)


class ImportedColumn(StrictModel):
    """Where a channel came from."""

    column: Label
    factor: Finite
    number: Count | None = None
    unit: Label | None = None
    offset: Finite = 0.0
    clock: Label | None = None
    days: Label | None = None
    part: Label | None = None
    units: Label | None = None


class Imported(StrictModel):
    """How a foreign file was read; what kind of file it was decides which entries there are."""

    file: Label
    sha256: Sha256
    columns: dict[Label, ImportedColumn]
    r0_ohm: Finite | None
    separator: Label | None = None
    decimal: Label | None = None
    encoding: Label | None = None
    sheet: Label | None = None
    group: Label | None = None
    header_row: Count | None
    units_row: Count | None = None
    negate: Annotated[list[Label], Field(max_length=20)] = Field(default_factory=list)
    zero: dict[Label, Label | None] = Field(default_factory=dict)
    repeat: Label | None = None
    doubts: Annotated[list[Remark], Field(max_length=100)] = Field(default_factory=list)
    notes: Annotated[list[Remark], Field(max_length=100)] = Field(default_factory=list)


class Aligned(StrictModel):
    """How a recording was brought to the plan's clock; see `testbench.campaigns.alignment.Alignment`."""

    delay_s: Finite
    drift_ppm: Finite
    offset_mm: Finite
    correlation: Finite
    rms_mm: Finite
    source: Label


class Recipe(StrictModel):
    """Everything needed to make a campaign again; which entries there are depends on its origin."""

    sensor: Label | None = None
    program: Literal["program.tap"] | None = None
    program_sha256: Sha256 | None = None
    # of a simulated one
    model: StoredModel | None = None
    seed: Seed | None = None
    grid_hz: Annotated[float, Field(gt=0, le=1e5)] | None = None
    instruments: Instruments | None = None
    past_sha256: Annotated[list[Sha256], Field(max_length=1000)] | None = None
    rest_s: Rest | Annotated[list[Rest], Field(max_length=1000)] | None = None
    effects_sha256: Sha256 | None = None
    # of a recorded one
    port: Annotated[str, Field(min_length=1, max_length=500)] | None = None
    baud: Annotated[int, Field(gt=0, le=100_000_000)] | None = None
    max_force_N: Annotated[float, Field(gt=0)] | None = None
    max_strain: Annotated[float, Field(gt=0)] | None = None
    # of one that was made from something else
    import_: Imported | None = Field(None, alias="import")
    time_offset_s: Finite | None = None
    aligned: Aligned | None = None

    def to_dict(self) -> dict[str, Any]:
        """The entries that the file has, as plain data."""
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True)


class Counts(StrictModel):
    """What became of the samples."""

    samples: Count = 0
    lost: Count = 0
    rejected: dict[Label, Count] = Field(default_factory=dict)
    unwritten: Count = 0
    sync_failures: Count = 0
    dropped: Count = 0
    moved: Count = 0
    repeated: Count = 0


NEEDED = {
    "simulated": ("sensor", "model", "seed", "program", "program_sha256", "instruments"),
    "recorded": ("sensor", "port", "baud", "max_force_N", "max_strain", "program", "program_sha256"),
    "imported": ("import_",),
    "aligned": ("aligned",),
}


class StoredCampaign(StrictModel):
    """The key ``knitbench`` of a manifest."""

    format: Literal["knitbench-campaign"]
    version: Literal[1]
    gauge_length_mm: GaugeLength | None  # null where no displacement was recorded
    origin: Origin
    status: Status
    recipe: Recipe
    counts: Counts
    versions: Annotated[dict[Label, Label], Field(max_length=100)]
    manifest_sha256: Sha256

    @model_validator(mode="after")
    def _recipe_of_its_origin(self) -> StoredCampaign:
        missing = [name for name in NEEDED[self.origin] if name not in self.recipe.model_fields_set]
        if missing:
            raise ValueError(f"recipe: a {self.origin} campaign needs {missing[0].rstrip('_')}")
        return self


class Resource(ExtraIgnored):
    """One file of a campaign."""

    path: FileName
    bytes: Count | None = None
    hash: Annotated[str, Field(pattern=r"^sha256:[0-9a-f]{64}$")] | None = None


class StoredManifest(ExtraIgnored):
    """``datapackage.json``, of which other tools may know more entries."""

    resources: Annotated[list[Resource], Field(max_length=10_000)]
    knitbench: StoredCampaign


class IndexEntry(StrictModel):
    """One campaign of a data set."""

    campaign: FileName
    sensor: Label
    program: Label
    seed: Seed
    specimen: Annotated[str, Field(max_length=400)] = ""
    split: Literal["", "train", "validation", "test"] = ""
    samples: Count
    manifest_sha256: Sha256


class StoredIndex(StrictModel):
    """``dataset.json``."""

    format: Literal["knitbench-dataset"]
    version: Literal[1]
    campaigns: list[IndexEntry]


EVENTS = "events.jsonl"  # what happened during a recording, a line each


class StoredEvent(ExtraIgnored):
    """One line of `EVENTS`, as far as a recording that goes on must know it."""

    event: Label
    channels: Annotated[list[Label], Field(max_length=20)] | None = None
    time_s: Annotated[float, Field(ge=0, le=1e10)]
    lost: Annotated[int, Field(ge=0, lt=1 << 40)] | None = None
    boot: Annotated[str, Field(pattern=r"^[0-9a-f]{8}$")] | None = None
    sequence: Annotated[int, Field(ge=0, lt=1 << 32)] | None = None
    micros: Annotated[int, Field(ge=0, lt=1 << 32)] | None = None


def checked_model(data: Any, source: str | Path) -> dict[str, Any]:
    """Plain data of a model file, its effects checked; another format is left to `model_from_dict` to name.

    Raises
    ------
    UserError
        If an effect is not what `StoredEffect` says.
    """
    if not isinstance(data, dict):
        return {"format": type(data).__name__}
    if data.get("format") != MODEL_FORMAT or data.get("version") != MODEL_VERSION:
        return data
    return data | validated(data, StoredModel, source, "model").model_dump(mode="json")


def read_model(path: str | Path) -> dict[str, Any]:
    """Plain data of the model in a file; see `checked_model`."""
    return checked_model(read_json(path, "model"), path)
