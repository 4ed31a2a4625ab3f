"""Saving and reading compensators: plain JSON, checked on the way in."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from compensation.engines.network import DEEPEST, WIDEST, Network
from compensation.memories.ema import SMALLEST_ALPHA
from compensation.memories.history import SETTLE_S, History
from compensation.model.compensator import Beginning, Scaling, Seen, TrainedCompensator
from compensation.model.runtime import LARGEST_RATE_HZ, SMALLEST_RATE_HZ
from gcode.support.console import knitbench_version
from gcode.support.errors import UserError, first_problem
from gcode.support.files import write_json
from gcode.support.strict import json_of, read_json
from testbench.recordings.doubts import say_once

FORMAT, FORMAT_VERSION = "knitbench-compensator", 4
# Version 2 has no `seen` and no `beginning`; version 3 no `settle_s`.
READABLE = (2, 3, 4)

# What a chip's float32 and products of a few of them can hold.
LARGEST, SMALLEST = 1e12, 1e-30
_Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
_Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]
# Within six orders of magnitude of a second.
_Time = Annotated[float, Field(ge=1e-6, le=1e6)]
_Numbers = Annotated[list[_Number], AfterValidator(np.asarray)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class _Scaling(_Strict):
    mean: _Number
    scale: _Positive


class _Network(_Strict):
    weights: list[list[list[_Number]]]
    biases: list[Annotated[list[_Number], Field(max_length=WIDEST)]] = Field(max_length=DEEPEST + 1)


class _History(_Strict):
    motion_taus_s: list[_Time]
    play_radii: list[_Positive]
    settle_s: _Time = SETTLE_S


def _ordered(ends: Sequence[float]) -> Sequence[float]:
    if ends[0] > ends[1]:
        raise ValueError(f"the lower end {ends[0]:g} lies above the upper one {ends[1]:g}")
    return ends


class _Seen(_Strict):
    low: _Number
    high: _Number
    inputs_low: _Numbers
    inputs_high: _Numbers

    @model_validator(mode="after")
    def _not_upside_down(self) -> Self:
        for ends in ((self.low, self.high), *zip(self.inputs_low, self.inputs_high, strict=False)):
            _ordered(ends)
        return self


class _Beginning(_Strict):
    gain: _Numbers
    offset: _Numbers


class _Promise(BaseModel):
    model_config = ConfigDict(extra="allow", strict=True)
    r2: float


class _Recalibration(BaseModel):
    model_config = ConfigDict(extra="allow", strict=True)
    on: str
    marks: list[int] = []


class _Recipe(BaseModel):
    """What `score` and `recalibrate` read of how a compensator was trained; the rest is for people."""

    model_config = ConfigDict(extra="allow", strict=True)
    trained_on: list[str] = []
    trained_digests: list[str] = []
    trained_marks: list[int] = []
    cross_validated: _Promise | None = None
    # All of them, one after another; an older file has the last one alone.
    recalibrated: Annotated[
        list[_Recalibration], BeforeValidator(lambda told: told if isinstance(told, list) else [told])
    ] = []


class _File(_Strict):
    format: str
    version: int
    knitbench: str
    target: str = Field(pattern="^(force|displacement)$")
    rate_hz: Annotated[float, Field(ge=SMALLEST_RATE_HZ, le=LARGEST_RATE_HZ)]
    alphas: list[Annotated[float, Field(ge=SMALLEST_ALPHA, le=1)]] = Field(min_length=1)
    start: str = Field(pattern="^(paper|causal)$")
    irregular: bool
    per_recording: bool
    sign: Annotated[float, Field(ge=-1, le=1)]
    history: _History
    scaling_in: _Scaling
    scaling_out: _Scaling
    networks: list[_Network] = Field(min_length=1)
    seen: _Seen | None = None
    beginning: _Beginning | None = None
    margins: Annotated[list[_Number], Field(min_length=2, max_length=2), AfterValidator(_ordered)] | None = None
    recipe: _Recipe
    sha256: str


def save(path: str | Path, compensator: TrainedCompensator) -> None:
    """Write a compensator as JSON, atomically, with a digest of its own content.

    Raises
    ------
    UserError
        If `load` would refuse it: a number is none, or beyond what a chip could hold.
    """
    written = {"format": FORMAT, "version": FORMAT_VERSION, "knitbench": knitbench_version(), **vars(compensator)}
    try:
        data = json_of(json.dumps(written, default=_plain, allow_nan=False), "compensator")
        data["sha256"] = _digest(data)
        _built(data)
    except ValueError as error:
        raise UserError(
            f"{path}: not written, for nothing could read it again: {first_problem(error)}; bring conductance and "
            "target to usual units, and train again"
        ) from None
    write_json(path, data)


def load(path: str | Path) -> TrainedCompensator:
    """Read a compensator that `save` or ``compensation train`` has written.

    Parameters
    ----------
    path : path

    Returns
    -------
    TrainedCompensator
        For `predicted`, `CompensatorStream`, `c_header` and `write_onnx`; ``.target``, ``.unit`` and ``.rate_hz`` say
        what it predicts.

    Raises
    ------
    UserError
        If the file is missing, foreign, of another version, malformed, or changed since it was saved.

    Examples
    --------
    >>> import tempfile
    >>> import testbench as tb
    >>> from compensation import Compensator, load
    >>> recording = tb.example(duration_s=60).resampled(20.0)
    >>> model = Compensator(method="paper").fit(recording.conductance_S[:, None], recording["force_N"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     model.save(f"{folder}/knit.json")
    ...     compensator = load(f"{folder}/knit.json")
    >>> compensator.target, compensator.unit, compensator.rate_hz
    ('force', 'N', 20.0)
    """
    data = read_json(path, "compensator")
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise UserError(
            f"{path}: not a compensator (its format must be {FORMAT!r}); make one with `compensation train`"
        )
    if data.get("version") not in READABLE:
        from testbench.comparing.words import listed  # heavy, and needed for this sentence only

        known = listed([str(version) for version in READABLE])
        raise UserError(f"{path}: compensator version {data.get('version')!r}; this knitbench reads {known}")
    try:
        built = _built(data)
    except ValueError as error:
        raise UserError(f"{path}: not a usable compensator: {first_problem(error)}") from None
    if _digest({key: value for key, value in data.items() if key != "sha256"}) != data["sha256"]:
        raise UserError(f"{path}: the file was changed after it was saved (its checksum is wrong); train it again")
    if built.is_dead:
        say_once(
            f"{path}: its network is dead, its output hardly moves; train with another --seed or more --restarts"
        )
    return built


def _built(data: dict[str, Any]) -> TrainedCompensator:
    """The compensator that a file holds; a `ValueError` says why nothing could run that."""
    checked = _File.model_validate(data)
    networks = tuple(Network.from_lists(net.weights, net.biases) for net in checked.networks)
    remembered = checked.history
    history = History(tuple(remembered.motion_taus_s), tuple(remembered.play_radii), remembered.settle_s)
    inputs = len(checked.alphas) + history.count
    if any(len(net.weights[0]) != inputs for net in networks):
        raise ValueError(f"its network does not take {inputs} inputs")
    vectors: list[list[float]] = []
    if checked.seen:
        vectors += [checked.seen.inputs_low, checked.seen.inputs_high]
    if checked.beginning:
        vectors += [checked.beginning.gain, checked.beginning.offset]
    if any(len(vector) != inputs for vector in vectors):
        raise ValueError(f"`seen` and `beginning` must hold {inputs} numbers each")
    as_they_are = ("target", "rate_hz", "start", "irregular", "per_recording", "sign")
    return TrainedCompensator(
        **{name: getattr(checked, name) for name in as_they_are},
        alphas=np.asarray(checked.alphas),
        scaling_in=Scaling(**vars(checked.scaling_in)),
        scaling_out=Scaling(**vars(checked.scaling_out)),
        networks=networks,
        history=history,
        recipe=checked.recipe.model_dump(exclude_unset=True),
        seen=Seen(**vars(checked.seen)) if checked.seen else None,
        beginning=Beginning(**vars(checked.beginning)) if checked.beginning else None,
        margins=(checked.margins[0], checked.margins[1]) if checked.margins else None,
    )


def _plain(part: Any) -> Any:
    """A part of a compensator, for JSON."""
    return part.tolist() if isinstance(part, np.ndarray) else vars(part)


def _digest(data: dict[str, Any]) -> str:
    # Python writes floats shortest-exact, so content that is equal has an equal digest.
    return hashlib.sha256(json.dumps(data, sort_keys=True, allow_nan=False).encode()).hexdigest()
