"""One test (a minute of it, or any other) as four testers, a logger, a spreadsheet and LabVIEW would export it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from testbench.importing.from_file import import_file
from testbench.importing.imported import Imported
from testbench.importing.wish import Wish

RATE_HZ, DURATION_S = 10.0, 60.0
TIME_S = np.round(np.arange(0.0, DURATION_S, 1 / RATE_HZ), 6)
EXTENSION_MM = np.round(6.0 * np.sin(2 * np.pi * TIME_S / 20.0) ** 2, 6)
FORCE_N = np.round(0.2 + 1.1 * EXTENSION_MM + 0.02 * TIME_S / 60, 6)
RESISTANCE_OHM = np.round(439_377.0 - 21_000.0 * EXTENSION_MM, 3)


def import_csv(path: Path, wish: Wish) -> Imported:
    """What is imported of a file that holds one recording."""
    (done,) = import_file(path, wish)
    return done


@dataclass(frozen=True, eq=False)
class Measured:
    """What was measured at the gauge length of 40 mm; each array has shape (n,)."""

    time_s: np.ndarray
    extension_mm: np.ndarray
    force_N: np.ndarray
    resistance_ohm: np.ndarray


MINUTE = Measured(TIME_S, EXTENSION_MM, FORCE_N, RESISTANCE_OHM)


def _rows(*columns: np.ndarray, form: str = "%.9f", separator: str = ",", decimal: str = ".") -> str:
    lines = [
        separator.join((form % value).replace(".", decimal) for value in row) for row in zip(*columns, strict=True)
    ]
    return "\n".join(lines) + "\n"


def testxpert(folder: Path, data: Measured = MINUTE) -> Path:  # noqa: PT028 (a tester, not a test)
    """testXpert: semicolons, decimal commas, a row of units; the force in kN, the resistance in kOhm, Latin-1."""
    head = "Prüfzeit;Standardweg;Standardkraft;Widerstand\ns;mm;kN;kOhm\n"
    rows = _rows(
        data.time_s, data.extension_mm, data.force_N / 1e3, data.resistance_ohm / 1e3, separator=";", decimal=","
    )
    return _written(folder / "testxpert.txt", head + rows, "latin-1")


def bluehill(folder: Path, data: Measured = MINUTE) -> Path:
    """Bluehill: a title, quoted names, brackets in a row of their own, a table of results above the raw data."""
    head = (
        '"Results Table 1"\n"","Maximum Load","Tensile strain at Maximum Load"\n"","(N)","(%)"\n"1","6.82","15.0"\n\n'
        '"Specimen 1"\n\n"Time","Extension","Load","Corrected Position","Resistance"\n'
        '"(s)","(mm)","(N)","(mm)","(kOhm)"\n'
    )
    columns = (data.time_s, data.extension_mm, data.force_N, data.extension_mm + 0.01, data.resistance_ohm / 1e3)
    quoted = "".join(",".join(f'"{value:.9f}"' for value in row) + "\n" for row in zip(*columns, strict=True))
    return _written(folder / "bluehill.csv", head + quoted, "utf-8-sig")


def testsuite(folder: Path) -> Path:
    """MTS TestSuite: tabs, a preamble with bars and tabs, the names and their units on lines of their own."""
    head = (
        "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\nData Header:\tTime:\t12.5\tSec\t11/22/2026 9:30:00 AM\n"
        "Data Acquisition:\tTimed\n\nCrosshead\tAxial Force\tRunning Time\nmm\tN\tSec\n"
    )
    return _written(folder / "testsuite.dat", head + _rows(EXTENSION_MM, FORCE_N, TIME_S, separator="\t"), "utf-8")


def electropuls(folder: Path) -> Path:
    """WaveMatrix on an ElectroPuls: names in quotes with commas and brackets in them, a comma after the last."""
    head = (
        '"Total Time (s)","Cycle Elapsed Time (s)","Total Cycles","Load(ElectroPuls (0,1):Load) (N)",'
        '"Displacement(ElectroPuls (0,1):Digital Position) (mm)",\n'
    )
    cycles = np.floor(TIME_S / 10)
    return _written(
        folder / "electropuls.csv", head + _rows(TIME_S, TIME_S % 10, cycles, FORCE_N, EXTENSION_MM), "utf-8"
    )


def headerless(folder: Path, data: Measured = MINUTE) -> Path:
    """A script's output: no header; resistance, time, position (falls with stretch), its time, force, its time."""
    columns = (
        data.resistance_ohm,
        data.time_s,
        -data.extension_mm,
        data.time_s - 0.03,
        data.force_N,
        data.time_s + 0.02,
    )
    return _written(folder / "raw.csv", _rows(*columns), "utf-8")


def workbook(folder: Path, data: Measured = MINUTE) -> Path:
    """An Excel workbook: a page of remarks, then the data; the strain is shown in %, so its cells hold ratios."""
    import openpyxl

    book = openpyxl.Workbook()
    book.active.title = "Remarks"
    book.active.append(["Knit 3, fourth washing"])
    sheet = book.create_sheet("Data")
    sheet.append(["Specimen: knit 3"])
    sheet.append(["Time\n[ms]", "Strain [%]", "Force [cN]", "R [MΩ]"])
    rows = zip(data.time_s * 1e3, data.extension_mm / 40, data.force_N * 1e2, data.resistance_ohm / 1e6, strict=True)
    for values in rows:
        sheet.append([float(value) for value in values])
        sheet.cell(sheet.max_row, 2).number_format = "0.00%"
    book.save(folder / "lab.xlsx")
    return folder / "lab.xlsx"


def labview(folder: Path) -> Path:
    """A TDMS file of two waveforms: force and displacement on one clock, the resistance on a slower one."""
    from nptdms import ChannelObject, TdmsWriter

    start = np.datetime64("2026-03-01T09:30:00.000000")
    fast = {"wf_increment": 1 / RATE_HZ, "wf_start_offset": 0.0, "wf_start_time": start}
    slow = {"wf_increment": 2 / RATE_HZ, "wf_start_offset": 0.0, "wf_start_time": start}
    with TdmsWriter(str(folder / "lab.tdms")) as writer:
        writer.write_segment(
            [
                ChannelObject("Test", "Load", FORCE_N * 1e3, {**fast, "unit_string": "mN"}),
                ChannelObject("Test", "Position", EXTENSION_MM / 10, {**fast, "unit_string": "cm"}),
                ChannelObject("Test", "Resistance", RESISTANCE_OHM[::2] / 1e3, {**slow, "unit_string": "kOhm"}),
            ]
        )
    return folder / "lab.tdms"


def _written(path: Path, text: str, encoding: str) -> Path:
    path.write_bytes(text.encode(encoding))
    return path


def check_same(recording, resistance: bool = True) -> None:
    """It is the test that every export holds."""
    assert recording.time_s == pytest.approx(TIME_S, abs=1e-6)
    assert recording["displacement_mm"] == pytest.approx(EXTENSION_MM, abs=1e-5)
    assert recording["force_N"] == pytest.approx(FORCE_N, abs=1e-5)
    if resistance:
        assert recording["resistance_ohm"] == pytest.approx(RESISTANCE_OHM, rel=1e-6)
