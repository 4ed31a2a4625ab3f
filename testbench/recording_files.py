"""Reading and writing ``recording.csv`` and campaign folders as recordings."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gcode.support.errors import UserError
from gcode.support.files import atomic_path, read_json
from testbench.recording import DISPLACEMENT, FORCE, RESISTANCE, TIME, Recording

ORDER = (TIME, DISPLACEMENT, FORCE, RESISTANCE)
DECIMALS = {TIME: 6, DISPLACEMENT: 5, FORCE: 6, RESISTANCE: 3}


def load(path: Path, gauge_length_mm: float | None) -> Recording:
    """Read `path`, a CSV or a campaign folder. See `testbench.recording.read_recording`."""
    if path.is_dir():
        return _load_campaign(path, gauge_length_mm)
    if not path.exists():
        raise UserError(f"{path}: no such recording; give a CSV or a campaign folder")
    if gauge_length_mm is None:
        raise UserError(f"{path}: a bare CSV does not know its gauge length; add --gauge-length-mm")
    return _from_csv(path, gauge_length_mm)


def _load_campaign(folder: Path, gauge_length_mm: float | None) -> Recording:
    manifest_path = folder / "datapackage.json"
    if not manifest_path.exists():
        raise UserError(f"{folder}: no datapackage.json in this folder, so it is not a campaign")
    manifest = read_json(manifest_path, "campaign manifest")
    recipe = manifest.get("knitbench", {}) if isinstance(manifest, dict) else {}
    gauge = gauge_length_mm or recipe.get("gauge_length_mm")
    if gauge is None:
        raise UserError(f"{manifest_path}: no gauge_length_mm in it; add --gauge-length-mm")
    return _from_csv(folder / "recording.csv", float(gauge), recipe)


def _from_csv(path: Path, gauge_length_mm: float, metadata: dict | None = None) -> Recording:
    columns = read_columns(path)
    if TIME not in columns:
        raise UserError(f"{path}: no column {TIME} (found: {', '.join(columns)}); name yours with `testbench import`")
    time_s = columns.pop(TIME)
    return Recording(time_s, columns, gauge_length_mm, str(path), metadata or {})


def read_columns(path: Path) -> dict[str, np.ndarray]:
    """All numeric columns of a comma-separated file, by header name.

    Raises
    ------
    UserError
        If the file is empty, is not comma-separated, or a cell is not a number.
    """
    import pandas as pd

    try:
        frame = pd.read_csv(path)
    except pd.errors.EmptyDataError:
        raise UserError(f"{path}: the file is empty") from None
    except (pd.errors.ParserError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: not a readable CSV: {error}") from None
    except OSError as error:
        raise UserError(f"{path}: cannot read it: {error.strerror or error}") from None
    if frame.shape[1] == 1 and ";" in str(frame.columns[0]):
        raise UserError(f"{path}: semicolons between the columns; turn it into a recording with `testbench import`")
    return {str(name): _numbers(path, str(name), frame[name]) for name in frame.columns}


def _numbers(path: Path, name: str, column) -> np.ndarray:
    import pandas as pd

    numbers = pd.to_numeric(column, errors="coerce")
    wrong = np.flatnonzero(numbers.isna() & column.notna())
    if wrong.size:
        row, came = int(wrong[0]) + 2, column.iloc[int(wrong[0])]
        raise UserError(f"{path}: row {row}: {name} must be a number, got {came!r}")
    return numbers.to_numpy(dtype=np.float64)


def write_recording_csv(path: str | Path, recording: Recording) -> None:
    """Write ``recording.csv`` atomically, known columns first, in fixed decimals (same bytes from same data)."""
    import pandas as pd

    columns = {TIME: recording.time_s, **recording.channels}
    names = [name for name in ORDER if name in columns] + sorted(set(columns) - set(ORDER))
    text = {name: [f"{value:.{DECIMALS.get(name, 6)}f}" for value in columns[name]] for name in names}
    with atomic_path(path) as temporary:
        pd.DataFrame(text).to_csv(temporary, index=False, lineterminator="\n")
