"""Layouts that people really write, each by hand: read right without an option, or refused in one sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from testbench.cli import main
from testbench.recordings.files import read_recording

T = 0.1 * np.arange(400)
X = 5 * (1 - np.cos(0.6 * T))  # mm
F = 0.4 * X + 0.05 * np.sin(3 * T)  # N
R = 47_000 - 900 * X  # ohm


def rows(columns: tuple[np.ndarray, ...], separator: str = ",", decimal: str = ".", tail: str = "") -> str:
    lines = zip(*columns, strict=True)
    return "".join(
        separator.join(f"{value:.7f}".replace(".", decimal) for value in line) + tail + "\n" for line in lines
    )


def clock(seconds: float) -> str:
    return f"{int(seconds // 3600):02d}:{int(seconds // 60 % 60):02d}:{seconds % 60:06.3f}"


def clocked(day: str = "", start_s: float = 36_000, form: str = "{}") -> str:
    times = [form.format(clock((t + start_s) % 86_400)) for t in T]
    return "".join(f"{day}{time},{x:.5f},{f:.5f}\n" for time, x, f in zip(times, X, F, strict=True))


FX, FXR = (T, X, F), (T, X, F, R)
KOHM = (T, X, F, R / 1e3)
READ = {
    "byte order mark, decimal comma": "\ufeffZeit [s];Weg [mm];Kraft [N];Widerstand [kΩ]\n" + rows(KOHM, ";", ","),
    "trailing separator": "Zeit [s];Weg [mm];Kraft [N];Widerstand [kOhm];\n" + rows(KOHM, ";", ",", ";"),
    "tab, units after a blank line": "Time\tExtension\tLoad\tResistance\n\ns\tmm\tN\tohm\n" + rows(FXR, "\t"),
    "units in the third row": "Time\tExtension\tLoad\tResistance\nCh1\tCh2\tCh3\tCh4\ns\tmm\tkN\tkOhm\n"
    + rows((T, X, F / 1e3, R / 1e3), "\t"),
    "Chinese": "时间,位移,力值,电阻\n(s),(mm),(N),(Ω)\n" + rows(FXR),
    "Chinese, full-width brackets": "时间（s）,位移（mm）,力（N）,电阻（Ω）\n" + rows(FXR),
    "micro sign": "Time (s),Displacement (\u00b5m),Force (N)\n" + rows((T, 1e3 * X, F)),
    "Greek mu": "Time (s),Displacement (\u03bcm),Force (N),Conductance (\u03bcS)\n" + rows((T, 1e3 * X, F, 1e6 / R)),
    "ohm sign": "Time (s),Displacement (mm),Resistance (\u2126)\n" + rows((T, X, R)),
    "another order": "Load (N),Resistance (Ohm),Extension (mm),Elapsed time (s)\n" + rows((F, R, X, T)),
    "clock": "Time,Displacement (mm),Force (N)\n" + clocked(),
    "date and clock": "Date/Time,Displacement (mm),Force (N)\n" + clocked("2024-03-01 "),
    "displacement in percent": "Time (s),Displacement (%),Force (N)\n" + rows((T, X / 0.4, F)),
    "names with units behind a slash": "t/s;s/mm;F/N;R/kΩ\n" + rows(KOHM, ";", ","),
    "names with units behind a dash": "time_ms,disp_um,force_mN,res_kohm\n"
    + rows((1e3 * T, 1e3 * X, 1e3 * F, R / 1e3)),
    "quoted decimal commas": '"Zeit","Weg","Kraft"\n"s","mm","N"\n'
    + "".join(f'"{t:.2f}","{x:.5f}","{f:.5f}"\n'.replace(".", ",") for t, x, f in zip(T, X, F, strict=True)),
    "a line for the spreadsheet": "sep=;\nTime (s);Displacement (mm);Force (N)\n" + rows(FX, ";"),
    "titles with the separator": "Specimen;A1\nOperator;X, Y\n\nZeit;Weg;Kraft\ns;mm;N\n" + rows(FX, ";", ","),
    "a strain beside the displacement": "Time (s),Extension (mm),Load (N),Tensile strain (Extensometer) (%)\n"
    + rows((T, X, F, X / 0.4)),
    "names over two lines": '"Time\n(s)","Extension\n(mm)","Load\n(kN)","Resistance\n(kOhm)"\n'
    + rows((T, X, F / 1e3, R / 1e3)),
    "a remark over two lines": '"Knit 3\nwashed twice"\nTime (s),Extension (mm),Load (N)\n' + rows(FX),
    "a quotation mark that is left open": '"Knit 3\nTime (s),Extension (mm),Load (N)\n' + rows(FX),
    "a comment sign before the names": "# made: 2024\n# gauge: 40 mm\n# t (s), x (mm), F (N), R (Ohm)\n" + rows(FXR),
    "names with blanks, parted by blanks": "Time (s)  Disp (mm)   Force (N)  R (kOhm)\n" + rows(KOHM, "   "),
    "names at tabs, numbers at blanks": "Time (s)\tDisp (mm)\tForce (N)\tR (kOhm)\n" + rows(KOHM, "  "),
    "past midnight": "Time,Displacement (mm),Force (N)\n" + clocked(start_s=86_380),
    "in the afternoon": "Time,Displacement (mm),Force (N)\n" + clocked(start_s=4 * 3600, form="{} PM"),
    "minutes and seconds": "Time,Displacement (mm),Force (N)\n"
    + "".join(f"{int(t // 60):02d}:{t % 60:04.1f},{x:.5f},{f:.5f}\n" for t, x, f in zip(T, X, F, strict=True)),
    "a zone behind the clock": "Time,Displacement (mm),Force (N)\n" + clocked("2024-03-01T", form="{}+01:00"),
    "the minus of a typesetter": "Time (s),Displacement (mm),Force (N)\n" + rows((T, X, F)).replace("-", "−"),
    "units as people write them": "Time (sec.),Displacement (in.),Load (Kg),R (k Ohm)\n"
    + rows((T, X / 25.4, F / 9.80665, R / 1e3)),
    "Arduino": "millis,pos_um,loadcell_g,R_ohm\n" + rows((1e3 * T, 1e3 * X, F / 9.80665e-3, R)),
    "traditional Chinese": "時間 (s),位移 (mm),試驗力 (N),電阻 (kΩ)\n" + rows(KOHM),
    "inches and pounds": "Time (s),Extension (in),Load (lbf)\n" + rows((T, X / 25.4, F / 4.4482216)),
}
REFUSED = {
    "no units": ("Time,Displacement,Force\n" + rows(FX), "the file does not say its unit"),
    "a power of ten": ("Time (s),Extension (mm),Load N (x1000)\n" + rows(FX), "its unit 'N x1000' cannot be read"),
    "a power of ten above the unit": (
        "Time,Extension,Load x10^3\ns,mm,N\n" + rows(FX),
        "its unit 'x10^3 N' cannot be read",
    ),
    "points that may part thousands": (
        "Zeit [s];Weg [mm];R [Ohm]\n" + "".join(f"{n};{n % 7};47.{n:03d}\n" for n in range(30)),
        "cannot tell what the point means in numbers such as '47.000'; say --decimal",
    ),
    "an unknown unit": ("Time (s),Extension (mm),Load (zork)\n" + rows(FX), "its unit 'zork' cannot be read"),
    "a strain without unit": ("Time (s),Strain,Force (N)\n" + rows((T, X / 40, F)), "say --strain-unit"),
    "a force per length": ("Time (s),Displacement (mm),Force (N/m)\n" + rows(FX), "its unit 'N/m' cannot be read"),
    "a name twice": ("Time (s),Force (N),Displacement (mm),Force (N)\n" + rows((T, F, X, 2 * F)), "both fit force"),
    "two displacements": (
        "Time (s),Crosshead (mm),Extensometer (mm),Force (N)\n" + rows((T, X, 0.9 * X, F)),
        "both fit displacement",
    ),
    "a footer": ("Time (s),Displacement (mm),Force (N)\n" + rows(FX) + "\nMax,10.0,4.0\n", "--drop-bad leaves"),
    "a reading over range": (
        "Time (s),Displacement (mm),Resistance (Ω)\n" + rows((T, X, R)) + "40.0,0.0,OL\n",
        "must be a number, got 'OL'",
    ),
    "stamps that repeat": (
        "Time (s),Displacement (mm),Force (N)\n" + rows((np.floor(T), X, F)),
        "time must increase",
    ),
}


def imported(text: str, folder: Path) -> int:
    (folder / "lab.csv").write_text(text, encoding="utf-8")
    return main(["import", str(folder / "lab.csv"), "--gauge-length-mm", "40", "-o", str(folder / "out")])


@pytest.mark.parametrize("layout", READ)
def test_it_is_read_right_without_an_option(layout: str, tmp_path: Path, capsys) -> None:
    assert imported(READ[layout], tmp_path) == 0, capsys.readouterr().err
    found = read_recording(tmp_path / "out")
    assert found.time_s[-1] - found.time_s[0] == pytest.approx(T[-1], abs=2e-3)
    expected = {"displacement_mm": X, "force_N": F, "resistance_ohm": R}
    told = [name for name in expected if found.has(name)]
    assert len(told) >= 2
    for name in told:
        np.testing.assert_allclose(found[name], expected[name], rtol=2e-4, atol=1e-3)


@pytest.mark.parametrize("layout", REFUSED)
def test_what_cannot_be_told_is_refused_in_a_sentence(layout: str, tmp_path: Path, capsys) -> None:
    text, said = REFUSED[layout]
    assert imported(text, tmp_path) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "below", ["Time (ms),Extension (m),Load (kN)", "Maximum load (N),Extension (mm),Work (J)", "ms,m,kN"]
)
def test_rows_below_another_header_are_not_taken_along(tmp_path: Path, capsys, below: str) -> None:
    head = "Time (s),Extension (mm),Load (N)\n"
    later = rows((T + 100, X, F))
    (tmp_path / "lab.csv").write_text(head + rows(FX) + below + "\n" + later)
    argv = ["import", str(tmp_path / "lab.csv"), "--gauge-length-mm", "40", "-o", str(tmp_path / "out"), "--drop-bad"]
    assert main(argv) == 2
    assert "row 402 has other names or units" in capsys.readouterr().err
    (tmp_path / "lab.csv").write_text(head + rows(FX) + head + later)
    assert main(argv) == 0, "below the same header another run begins, after a pause"
    for name in ("out-1", "out-2"):
        assert len(read_recording(tmp_path / name)) == len(T)


def test_a_column_in_ohm_of_another_name_is_not_left_out_in_silence(tmp_path: Path, capsys) -> None:
    assert imported("Time (s),Extension (mm),Load (N),DMM [kΩ]\n" + rows(KOHM), tmp_path) == 0
    assert "column 4 'DMM [kΩ]' is in kΩ: if it is the resistance, say --resistance 4" in capsys.readouterr().out
