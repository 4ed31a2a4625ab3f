"""What the public functions accept: paths or objects, turned into objects."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from gcode.support.errors import UserError
from gcode.support.kinds import path_of
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel
from testbench.knit.presets import names as preset_names
from testbench.knit.presets import preset
from testbench.recordings.between import FRESH, Between
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TIME
from testbench.recordings.checks import known_length
from testbench.recordings.columns import numbers
from testbench.recordings.csv_columns import is_remark, listed
from testbench.recordings.doubts import check_distinct, check_gap, check_grid, say_if_same, say_sign, say_slow
from testbench.recordings.files import SPELLINGS, read_recording, say_of_temperature, strange_names
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile, check_same_set_up, load_model_file

if TYPE_CHECKING:
    import pandas as pd


class WithModel(Protocol):
    """A result that a model can be taken from: of `fit`, of `diagnose`."""

    @property
    def file(self) -> ModelFile:
        """The model with what is known of it."""
        ...


Source = str | Path | Recording
AnyModel = KnitModel | ModelFile | WithModel | str | Path
Effects = Catalogue | type[Effect] | Iterable[type[Effect]] | str | Path | None


def read(source: str | Path | pd.DataFrame | Mapping[str, Any], gauge_length_mm: float | None = None) -> Recording:
    """Read a recording from a CSV, a campaign folder, a data frame or a mapping of columns.

    Parameters
    ----------
    source : path, DataFrame or mapping of str to array, each shape (n,)
        With columns ``time_s``, ``displacement_mm``, ``force_N``, ``resistance_ohm``; force or resistance may be
        missing. Other columns without a single number, such as remarks, are left out. A table of polars or Arrow
        counts as a data frame; the times may be the index of one, if that is called ``time_s``.
    gauge_length_mm : float, optional
        Length of the unstretched sensor between the clamps, in mm; a campaign knows its own.

    Returns
    -------
    Recording
        Its samples as they are: jittered, never resampled.

    Raises
    ------
    UserError
        If it is missing or malformed; the message names the file, the row and the remedy.

    Examples
    --------
    >>> import testbench as tb
    >>> tb.read({"time_s": [0, 1, 2], "displacement_mm": [0, 1, 0], "force_N": [0, 2, 1]}, gauge_length_mm=25)
    <Recording columns-c0d3dd2b: 3 samples in 2.0 s, gauge length 25 mm, displacement_mm, force_N>
    """
    if isinstance(source, str | Path):
        return read_recording(source, gauge_length_mm)
    table = _columns_in(source)
    _check_names(str(name) for name, _ in table)
    named = {str(name): values for name, values in table}
    columns = {name: numbers("read", name, values) for name, values in named.items() if not _is_remark(name, values)}
    if TIME not in columns:
        raise UserError(f"read: no column {TIME} (found: {listed(named, columns)}); rename yours")
    if gauge_length_mm is None and DISPLACEMENT in columns:
        raise UserError("read: a table does not know its gauge length; give gauge_length_mm")
    say_of_temperature("read", columns)
    time_s = columns.pop(TIME)
    return Recording(time_s, columns, known_length(gauge_length_mm, "read"))


def _columns_in(source: Any) -> list[tuple[Any, Any]]:
    """Names and values of the columns of a table in memory: pandas, polars, Arrow, or a mapping.

    Raises
    ------
    UserError
        If it is no table.
    """
    if hasattr(source, "items"):
        by_time = getattr(getattr(source, "index", None), "name", None) == TIME and TIME not in source
        return list((source.reset_index() if by_time else source).items())
    names = getattr(source, "column_names", None) or getattr(source, "columns", None)  # of Arrow; of polars
    if not isinstance(names, list) or not hasattr(source, "__getitem__"):
        raise UserError(f"read: must be a path, a data frame or a mapping of columns, got {type(source).__name__}")
    return [(name, source[name]) for name in names]


def _check_names(names: Iterable[str]) -> None:
    """Refuse a column that is meant as a channel and is not called so: every model would leave it out in silence.

    So, too, a name that two columns have: one of them would be left out.
    """
    found = list(names)
    if twice := [name for name in found if found.count(name) > 1]:
        raise UserError(f"read: {found.count(twice[0])} columns are called {twice[0]!r}; name each column once")
    for channel in (one for one in (DISPLACEMENT, FORCE, RESISTANCE) if one not in found):
        quantity, _, unit = channel.partition("_")
        like = [name for name in found if name.lower().startswith(quantity)]
        if channel in SPELLINGS:
            like += strange_names(found, channel)
        if like:
            raise UserError(
                f"read: column {like[0]!r} is not taken for the {quantity}; call it {channel}, in {unit}, "
                "or leave it out"
            )


def _is_remark(name: str, values: Any) -> bool:
    """Whether a column is text from top to bottom, as remarks are: it is left out, as that of a CSV."""
    import pandas as pd

    column = np.asarray(values)
    return column.ndim == 1 and column.dtype.kind in "OUT" and is_remark(name, pd.Series(column.astype(object)))


def as_recording(source: Source, gauge_length_mm: float | None, usual_mm: float | None = None) -> Recording:
    """A recording, read where a path was given.

    Parameters
    ----------
    source : Recording or path
    gauge_length_mm : float, optional
        As the user gave it: for the path of a bare CSV.
    usual_mm : float, optional
        What it is taken for there where the user gave none.

    Raises
    ------
    UserError
        If it is no recording, or `gauge_length_mm` is another one than that of a recording in memory: it would be
        left out in silence.
    """
    if not isinstance(source, Recording | str | Path):
        given = hasattr(source, "recording") and "give its `recording`"
        raise UserError(
            f"recording: must be a Recording, a CSV or a campaign folder, got {type(source).__name__}; "
            f"{given or 'testbench.read makes a Recording of a data frame'}"
        )
    if not isinstance(source, Recording):
        return read_recording(source, usual_mm if gauge_length_mm is None else gauge_length_mm)
    given_mm = known_length(gauge_length_mm, source.source)
    if gauge_length_mm is not None and source.has(DISPLACEMENT) and given_mm != source.gauge_length_mm:
        raise UserError(
            f"{source.source}: this recording has a gauge length of {source.gauge_length_mm:g} mm, got "
            f"{given_mm:g} mm; leave gauge_length_mm out, or give the right one where the recording is made"
        )
    return source


def recording_of(source: Source, gauge_length_mm: float | None = None, usual_mm: float | None = None) -> Recording:
    """A recording with its displacement, which every model needs; doubts about it are said on stderr, once.

    See `as_recording` for the lengths.

    Raises
    ------
    UserError
        If it has no displacement, or is nearly nothing but one gap; see also `as_recording`.
    """
    recording = as_recording(source, gauge_length_mm, usual_mm)
    recording.needs_displacement()
    check_gap(recording)
    say_sign(recording)
    say_slow(recording)
    return recording


def recordings_for(
    model: AnyModel | None,
    file: ModelFile | None,
    recording: Source,
    held_out: Source | None,
    gauge_length_mm: float | None,
    clamp_play_mm: float = 0.0,
    rest_s: float | None = None,
) -> tuple[Recording, Recording | None, Between]:
    """Both recordings, of the model's set-up where there is a model, and what happened between them.

    Parameters
    ----------
    model : KnitModel, result, path or None
        As the user gave it: errors name its path.
    file : ModelFile or None
        What it is.
    recording, held_out : Recording or path
    gauge_length_mm : float, optional
        Default: the model's.
    clamp_play_mm : float
        0: as the model was fitted.
    rest_s : float, optional
        None: as the model was fitted.
    """
    usual_mm = (file.gauge_length_mm or None) if file else None  # 0: not known
    first = recording_of(recording, gauge_length_mm, usual_mm)
    if file is not None:
        check_same_set_up(file, first, model if isinstance(model, str | Path) else "model")
    second = None if held_out is None else recording_of(held_out, gauge_length_mm, usual_mm)
    kept = file.between if file is not None and second is not None else FRESH
    between = Between(clamp_play_mm or kept.clamp_play_mm, kept.rest_s if rest_s is None else rest_s)
    if second is not None:
        # Imported here: they are slow, and a recorder must start at once.
        from testbench.measurements.preparing import MAX_GRID_HZ
        from testbench.measurements.splitting import MIN_PART

        check_grid([second], first, MAX_GRID_HZ, MIN_PART, between.rest_s or 0.0)
        if between.rest_s is None:
            say_if_same(second, first)
        else:
            check_distinct([first, second], "what is held out is made after a rest: give another recording")
    return first, second, between


def catalogue_of(effects: Effects) -> Catalogue:
    """The catalogue, with a user's own effects: from a file, or classes.

    Raises
    ------
    UserError
        If one of them has the name of another effect.
    """
    if isinstance(effects, Catalogue):
        return effects
    if effects is None or isinstance(effects, str | Path):
        return load_catalogue(effects)
    catalogue = load_catalogue()
    given: Any = effects
    single = isinstance(given, type | Effect) or not isinstance(given, Iterable)  # an Effect iterates over its fields
    for effect in [given] if single else given:
        if not (isinstance(effect, type) and issubclass(effect, Effect)):
            raise UserError(f"effects: must be a file, or classes of your own effects, got {effect!r}")
        catalogue.add(effect, "effects")
    return catalogue


def own_file(effects: str | Path | None) -> Path | None:
    """The file with the user's own effects, where one is needed: it is copied beside what was made with it.

    Raises
    ------
    UserError
        If it is no path.
    """
    return None if effects is None else path_of(effects, "file with your own effects")


def model_file_of(model: AnyModel, catalogue: Catalogue) -> ModelFile:
    """A model with what is known of it; of a bare one, or a preset, nothing is.

    Raises
    ------
    UserError
        If it is no model, the file of one, or the name of a preset.
    """
    if isinstance(model, str | Path):
        if is_preset(model):
            return ModelFile(preset(str(model)), 0.0)
        if not Path(model).exists():
            raise UserError(f"{model}: no such model.json, and no preset; presets are {', '.join(preset_names())}")
        return load_model_file(model, catalogue)
    file = ModelFile(model, 0.0) if isinstance(model, KnitModel) else getattr(model, "file", model)
    if not isinstance(file, ModelFile):
        raise UserError(
            f"model: must be a KnitModel, a result of fit or diagnose, a model.json or a preset; "
            f"got {type(model).__name__}"
        )
    return file


def is_preset(model: AnyModel) -> bool:
    """Whether a model is named as a preset is: ``pes``, or ``pes@3`` for the third specimen of its kind."""
    return isinstance(model, str) and model.partition("@")[0] in preset_names()


def model_name(model: AnyModel) -> str:
    """What a manifest calls a sensor: its preset, or the name of its file; ``model`` where it has none."""
    if is_preset(model):
        return str(model)
    return Path(model).name if isinstance(model, str | Path) else "model"
