"""A case as a folder: recordings that anybody may open, and the truth sealed apart."""

from __future__ import annotations

from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.files import check_folder, make_folder, write_json, write_text
from testbench.recordings.files import write_recording_csv
from testbench.worlds.case import Case

RECORDINGS, SEALED = "recordings", "sealed"

README = """\
One sensor, pulled twice on a tensile tester: calibration.csv and held_out.csv.
Gauge length: {gauge:g} mm. The sensor starts fresh (never stretched) in both.
Columns: {columns}.

Something may be going on in this sensor that a plain model of it does not know: an effect of the yarn, the
contacts, the grips or the instruments. Or nothing may. Find out:

  testbench diagnose {name}/recordings/calibration.csv --held-out {name}/recordings/held_out.csv \\
      --gauge-length-mm {gauge:g}

Then open {name}/sealed/truth.json, and not before.
"""


def check_new(folder: str | Path) -> Path:
    """Refuse a place that no case can be written to, before the work whose result would be lost there."""
    folder = check_folder(folder)
    if folder.is_dir() and any(folder.iterdir()):
        raise UserError(f"{folder}: the folder is not empty; choose another")
    return folder


def write_case(folder: str | Path, case: Case) -> Path:
    """Write `case` to a new folder; nothing outside ``sealed/`` tells what is hidden.

    Raises
    ------
    UserError
        If the folder holds anything already: a case in work must not be replaced unseen.
    """
    folder = make_folder(check_new(folder))
    recordings, sealed = make_folder(folder / RECORDINGS), make_folder(folder / SEALED)
    write_recording_csv(recordings / "calibration.csv", case.calibration)
    write_recording_csv(recordings / "held_out.csv", case.held_out)
    write_json(sealed / "truth.json", case.truth)
    columns = ", ".join(["time_s", *case.calibration.channels])
    text = README.format(gauge=case.calibration.gauge_length_mm, columns=columns, name=folder.name)
    write_text(folder / "README.txt", text)
    return folder
