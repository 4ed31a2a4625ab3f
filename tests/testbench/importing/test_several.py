"""Several recordings in one file, as testers and loggers write them: side by side, or below each other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.cli import main
from testbench.importing.from_file import import_file, look
from testbench.importing.imported import Imported
from testbench.importing.wish import Wish

COUNTS = (40, 25, 33)


def run(number: int, start_s: float = 0.0) -> list[tuple[float, float, float]]:
    """Time in s, displacement in mm and force in N of one of three specimens, the stiffer the later."""
    time_s = 0.05 * np.arange(COUNTS[number])
    stretch_mm = 4 * np.sin(time_s) ** 2
    return list(zip(start_s + time_s, stretch_mm, (1 + number) * stretch_mm, strict=True))


def cells(row: Sequence[float] | None, separator: str = ",", decimal: str = ".") -> str:
    return separator.join(f"{value:.4f}".replace(".", decimal) for value in row) if row else separator * 2


def lines(number: int, start_s: float = 0.0) -> str:
    return "".join(cells(row) + "\n" for row in run(number, start_s))


def beside(separator: str = ",", decimal: str = ".", gap: str = "", first: str = "") -> str:
    rows = zip_longest(*(run(number) for number in range(3)))
    between = f"{separator}{gap}"
    return "".join(first + between.join(cells(one, separator, decimal) for one in row) + "\n" for row in rows)


def check(found: list[Imported], labels: Sequence[str] = ("1", "2", "3")) -> None:
    assert [one.label for one in found] == list(labels)
    for one in found:
        time_s, stretch_mm, force_N = np.transpose(run(int(one.label) - 1))
        assert one.recording.time_s == pytest.approx(time_s, abs=1e-4)
        assert one.recording["displacement_mm"] == pytest.approx(stretch_mm, abs=1e-4)
        assert one.recording["force_N"] == pytest.approx(force_N, abs=1e-4)


PLAIN = "Time (s),Extension (mm),Load (N)\n"
GERMAN = "Prüfzeit;Standardweg;Standardkraft"
BESIDE = {
    "Bluehill": "Specimen 1,,,Specimen 2,,,Specimen 3,,\n"
    + ",".join(["Time,Extension,Load"] * 3)
    + "\n"
    + ",".join(["(s),(mm),(N)"] * 3)
    + "\n"
    + beside(),
    "testXpert": "Probe 1;;;Probe 2;;;Probe 3;;\n"
    + f"{GERMAN};{GERMAN};{GERMAN}\n"
    + "s;mm;N;s;mm;N;s;mm;N\n"
    + beside(";", ","),
    "a gap between": ",,".join([PLAIN.strip()] * 3) + "\n" + beside(gap=","),
    "a number of each row": "No.," + ",".join([PLAIN.strip()] * 3) + "\n" + beside(first="7,"),
    "numbered": ",".join(f"time_s_{n},ext_mm_{n},load_N_{n}" for n in "123") + "\n" + beside(),
    "named by pandas": ",".join(PLAIN.strip().replace(")", f"){end}") for end in ("", ".1", ".2")) + "\n" + beside(),
    "numbered before": ",".join(f"Probe {n} Zeit (s),Probe {n} Weg (mm),Probe {n} Kraft (N)" for n in "123")
    + "\n"
    + beside(),
    "empty cells left out at the end": ",".join([PLAIN.strip()] * 3)
    + "\n"
    + "\n".join(line.rstrip(",") for line in beside().splitlines())
    + "\n",
}


def written(folder: Path, text: str) -> Path:
    (folder / "lab.csv").write_text(text, encoding="utf-8")
    return folder / "lab.csv"


@pytest.mark.parametrize("layout", BESIDE)
def test_specimens_side_by_side(tmp_path, layout):
    path = written(tmp_path, BESIDE[layout])
    check(import_file(path, Wish(40.0)))
    check(import_file(path, Wish(40.0, repeat=2)), ["2"])
    with pytest.raises(UserError, match="no repeat 4 among the specimens side by side: they are 1 to 3"):
        import_file(path, Wish(40.0, repeat=4))


def test_a_column_by_its_number_is_that_column_and_one_by_name_is_that_of_each_specimen(tmp_path):
    path = written(tmp_path, BESIDE["Bluehill"])
    named = {"time": "Time", "displacement": "Extension", "force": "Load"}
    check(import_file(path, Wish(40.0, named)))
    (one,) = import_file(path, Wish(40.0, {"time": "4", "displacement": "5", "force": "6"}))
    assert one.recording["force_N"] == pytest.approx(np.transpose(run(1))[2], abs=1e-4)
    _, choice = look(path, Wish(40.0, repeat=3))
    assert choice.taken["force"].column.number == 9


@pytest.mark.parametrize(
    "names",
    [
        "Time (s),Extension (mm),Load (N),Time (s),Extension (mm),Load (kN)",
        "Time (s),Extension (mm),Load (N),Time (s),Load (N),Extension (mm)",
        "Time (s),Extension (mm),Load (N),Cycle,Extension (mm),Load (N)",
    ],
)
def test_columns_that_are_not_alike_are_no_specimens(tmp_path, names):
    path = written(tmp_path, names + "\n" + "".join(f"{n},{n},{n},{n},{n},{n}\n" for n in range(20)))
    with pytest.raises(UserError, match="both fit"):
        import_file(path, Wish(40.0))


BELOW = {
    "the names again": "".join(PLAIN + lines(number) for number in range(3)),
    "titles, blank lines": "\n".join(f"Run {number + 1}\n{PLAIN}{lines(number)}" for number in range(3)),
    "names and units": "\n".join(
        f'"Specimen {number + 1}"\n"Time","Extension","Load"\n"(s)","(mm)","(N)"\n{lines(number)}'
        for number in range(3)
    ),
    "settings before each": "\n".join(
        f"Specimen label,knit {number}\nWidth,25.0,mm\nLength,40.0,mm\nStarted,14/03/2026 09:5{number}:00\n\n"
        f"{PLAIN}{lines(number)}"
        for number in range(3)
    ),
    "a board that began anew": "".join(f"HX711 ready\n{PLAIN}{lines(number, 0.5)}" for number in range(3)),
    "on one clock": "".join(PLAIN + lines(number, 100.0 * number) for number in range(3)),
}


@pytest.mark.parametrize("layout", BELOW)
def test_runs_below_each_other(tmp_path, layout):
    path = written(tmp_path, BELOW[layout])
    check(import_file(path, Wish(40.0)))
    check(import_file(path, Wish(40.0, repeat="3", sort=True)), ["3"])
    with pytest.raises(UserError, match="no repeat 4; it has 1, 2, 3; leave --repeat out"):
        import_file(path, Wish(40.0, repeat=4))


def test_without_names_between_them_a_run_is_named(tmp_path, capsys):
    path = written(tmp_path, PLAIN + "".join(map(lines, range(3))))
    with pytest.raises(UserError, match=r"the time starts again there.*--repeat N \(1 to 3\) takes one"):
        import_file(path, Wish(40.0))
    check(import_file(path, Wish(40.0, repeat=2)), ["2"])
    out = tmp_path / "one.csv"
    assert main(["import", str(path), "--gauge-length-mm", "40", "--repeat", "3", "-o", str(out)]) == 0
    assert len(out.read_text().splitlines()) == COUNTS[2] + 1


@pytest.mark.parametrize(
    "names", ["Time (ms),Extension (mm),Load (N)", "Time (s),Load (N),Extension (mm)", "Time,Extension,Load\nms,mm,N"]
)
def test_a_run_of_other_units_or_in_another_order_is_another_table(tmp_path, names):
    path = written(tmp_path, PLAIN + lines(0) + names + "\n" + lines(1))
    with pytest.raises(UserError, match="other names or units"):
        import_file(path, Wish(40.0))


def test_names_on_every_page_part_nothing(tmp_path):
    rows = lines(0).splitlines(keepends=True)
    path = written(tmp_path, "".join(PLAIN + "".join(rows[at : at + 8]) for at in range(0, 40, 8)))
    (one,) = import_file(path, Wish(40.0))
    assert (one.label, len(one.recording)) == ("", 40)


def test_a_lost_sample_beside_the_names_is_not_left_out_in_silence(tmp_path):
    path = written(tmp_path, PLAIN + lines(0) + "2.0,OL,OL\n" + PLAIN + lines(1))
    with pytest.raises(UserError, match=r"row 42: Extension .* must be a number, got 'OL'"):
        import_file(path, Wish(40.0))
