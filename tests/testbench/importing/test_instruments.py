"""One test as many testers, loggers and programs write it, in their manner and language: read without an option."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.importing.wish import Wish
from tests.testbench.importing.exports import import_csv

COUNT = 60
T = np.round(0.1 * np.arange(COUNT), 1)  # s
X = np.round(5 * (1 - np.cos(0.6 * T)), 5)  # mm
F = np.round(0.2 + 0.4 * X + 0.05 * np.sin(3 * T), 5)  # N
R = np.round(47_000 - 900 * X, 2)  # ohm
G_N, LBF_N, OZF_N = 9.80665e-3, 4.4482216152605, 4.4482216152605 / 16
LINE = [str(n + 1) for n in range(COUNT)]
CHANNELS = {"displacement_mm": X, "force_N": F, "resistance_ohm": R}


def stamps(form: str) -> list[str]:
    start = datetime(2026, 3, 1, 9, 30)
    return [(start + timedelta(seconds=float(t))).strftime(form)[:-3] for t in T]


def rows(*columns, sep: str = ",", dec: str = ".", quote: str = "", before: str = "") -> str:
    cells = [
        [cell if isinstance(cell, str) else f"{cell:.12g}".replace(".", dec) for cell in line]
        for line in zip(*columns, strict=True)
    ]
    return "".join(before + sep.join(f"{quote}{cell}{quote}" for cell in line) + "\n" for line in cells)


def european(*columns) -> str:
    return rows(*columns, sep=";", dec=",")


def tabs(*columns) -> str:
    return rows(*columns, sep="\t")


TESTERS = {
    "Zwick testXpert III": (
        '"Prüfprotokoll"\n"Prüfer:";"M"\n\n"Probe 1"\n"Prüfzeit";"Standardweg";"Standardkraft";"Kanal 4 Widerstand"\n'
        '"s";"mm";"N";"kOhm"\n' + european(T, X, F, R / 1e3),
        "cp1252",
    ),
    "Zwick testXpert III, strain": (
        "Prüfzeit;Dehnung;Standardkraft\ns;%;N\n" + european(T, X / 0.4, F),
        "cp1252",
    ),
    "Instron Bluehill Universal": (
        'Results Table 1\n,"Maximum Force\n(N)","Displacement at Maximum Force\n(mm)"\n1,"4.2","9.9"\n\n"Time\n(s)",'
        '"Displacement\n(mm)","Force\n(N)"\n' + rows(T, X, F, quote='"'),
        "utf-8-sig",
    ),
    "MTS TestSuite TW": (
        "Specimen:\t1\n\nTime\tCrosshead\tLoad\tStrain 1\ns\tmm\tN\tmm/mm\n" + tabs(T, X, F, X / 40),
        "utf-8",
    ),
    "Shimadzu Trapezium X": (
        '"試験名","引張"\n"日付","2026/03/01"\n\n"時間","試験力","ストローク"\n"sec","N","mm"\n'
        + rows(T, F, X, quote='"'),
        "cp932",
    ),
    "Tinius Olsen Horizon": (
        "Test Name,Tensile\nSpecimen ID,1\n\nPoint,Time (sec),Position (mm),Force (N)\n" + rows(LINE, T, X, F),
        "utf-8",
    ),
    "Lloyd NEXYGEN": (
        '"Batch Reference:","K1"\n"Load","Extension from preload","Time"\n"N","mm","s"\n' + rows(F, X, T),
        "utf-8",
    ),
    "Mecmesin VectorPro": (
        '"Sample 1"\n"Time (s)","Displacement (mm)","Load (N)","Event"\n' + rows(T, X, F, [""] * COUNT),
        "utf-8",
    ),
    "Mark-10 MESUR": ("Reading,Load (lbF),Travel (in),Time (sec)\n" + rows(LINE, F / LBF_N, X / 25.4, T), "utf-8"),
    "Chatillon": ("Time (sec),Load (ozf),Deflection (in)\n" + rows(T, F / OZF_N, X / 25.4), "utf-8"),
    "Imada": ("No.,時間(s),荷重値(N),変位(mm)\n" + rows(LINE, T, F, X), "cp932"),
    "TA.XTplus Exponent": ("Force (g)\tDistance (mm)\tTime (sec)\n" + tabs(F / G_N, X, T), "utf-8"),
    "Deben Microtest": (
        "Time (secs)\tExtension (mm)\tForce (N)\tMotor speed (mm/min)\n" + tabs(T, X, F, [0.5] * COUNT),
        "utf-8",
    ),
    "Textechno": ("Zeit / s;Längenänderung / mm;Kraft / cN\n" + european(T, X, 100 * F), "cp1252"),
    "CellScale": (
        "SetName,Cycle,Time_S,Displacement_mm,Force_mN\n" + rows(["a"] * COUNT, LINE, T, X, 1e3 * F),
        "utf-8",
    ),
    "Bluehill, German": ("Zeit;Traversenweg;Last\n(s);(mm);(N)\n" + european(T, X, F), "cp1252"),
    "Bluehill, French": ("Temps;Déplacement;Charge\n(s);(mm);(kN)\n" + european(T, X, F / 1e3), "cp1252"),
    "testXpert, French": ("Temps d'essai;Course standard;Force standard\ns;mm;N\n" + european(T, X, F), "cp1252"),
    "Imada ZT-Logger": (
        "Date,2026/03/01\nUnit,N\nSampling,10[Hz]\n\nTime[s],Force[N],Displacement[mm]\n" + rows(T, F, X),
        "utf-8",
    ),
    "in/in": ("Time (s),Strain (in/in),Load (lbf)\n" + rows(T, X / 40, F / LBF_N), "utf-8"),
    "ADMET MTESTQuattro": ("Specimen,1\nTime,Position,Load\nsec,in,lb\n" + rows(T, X / 25.4, F / LBF_N), "utf-8"),
}
LOGGERS = {
    "Keithley KickStart": (
        "Model,2450\nSerial,0401\nTest name,R vs t\n\nReading,Relative Time (s),Force (N),Resistance (Ohm)\n"
        + rows(LINE, T, F, R),
        "utf-8",
    ),
    "Keysight BenchVue": (
        "#,Time,Resistance (Ω),Force (N)\n" + rows(LINE, stamps("%m/%d/%Y %H:%M:%S.%f"), R, F),
        "utf-8",
    ),
    "a buffer of readings": ("timestamps [s]\treadings [Ohm]\tForce (N)\n" + tabs(T, R, F), "utf-8"),
    "microstrain": ("time_ms,strain_ue,force_N\n" + rows(1e3 * T, X / 40e-6, F), "utf-8"),
    "Agilent 34970A": (
        "Scan,Time,101 <Force> (N),102 <Rsensor> (OHM)\n" + rows(LINE, stamps("%m/%d/%Y %H:%M:%S:%f"), F, R),
        "utf-16",
    ),
    "FlexLogger": (
        "Group,Log\nAbsolute Time,Time (s),Force (N),Position (mm)\n" + rows(stamps("%Y-%m-%dT%H:%M:%S.%f"), T, F, X),
        "utf-8",
    ),
    "HBM catman": (
        "Kanäle: 3\nT0 = 01.03.2026\nTime  1 - default sample rate [s]\tForce [N]\tWeg [mm]\n"
        + rows(T, F, X, sep="\t", dec=","),
        "cp1252",
    ),
    "DEWESoft": ("Data information\n\nTime (s),Force/AI 1 (N),Displacement/AI 2 (mm)\n" + rows(T, F, X), "utf-8"),
    "Hioki": (
        'HIOKI LR8431\n"Time","CH1-1 Force[N]","CH1-2 Disp[mm]"\n' + rows(stamps("%H:%M:%S.%f"), F, X),
        "utf-8",
    ),
    "ESP32": ("I (1234) SENSOR: start\ntime_ms,pos_mm,force_N,R_kohm\n" + rows(1e3 * T, X, F, R / 1e3), "utf-8"),
    "PuTTY": ("=~=~= PuTTY log 2026.03.01 09:30:00 =~=~=\ntime_s,disp_mm,force_N\n" + rows(T, X, F), "utf-8"),
    "PlatformIO": (
        "".join(
            f"{stamp} > {line}\n"
            for stamp, line in zip(
                stamps("%H:%M:%S.%f")[:1] + stamps("%H:%M:%S.%f"),
                f"time_s,disp_mm,force_N\n{rows(T, X, F)}".split(),
                strict=True,
            )
        ),
        "utf-8",
    ),
    "seconds since 1970": ("epoch_s,disp_mm,force_N\n" + rows(1.7723e9 + T, X, F), "utf-8"),
}
PROGRAMS = {
    "MATLAB writetable": ("Time_s_,Displacement_mm_,Force_N_,Resistance_Ohm_\n" + rows(T, X, F, R), "utf-8"),
    "MATLAB, strain": ("Time_s_,Strain_mm_mm_,Force_N_\n" + rows(T, X / 40, F), "utf-8"),
    "R write.csv2": (
        '"";"Time..s.";"Extension..mm.";"Load..N."\n' + european([f'"{n}"' for n in LINE], T, X, F),
        "utf-8",
    ),
    "R, from DIN": ('"t.s" "s.mm" "F.N" "R.kOhm"\n' + rows(T, X, F, R / 1e3, sep=" "), "utf-8"),
    "Origin": ("Time\tDisplacement\tForce\ns\tmm\tN\nknit 1\tknit 1\tknit 1\n" + tabs(T, X, F), "utf-8"),
    "numpy, no blanks in names": ("t_[s] Weg_[mm] Load_(N) R_(Ohm)\n" + rows(T, X, F, R, sep=" "), "utf-8"),
    "pandas": (",time_s,disp_mm,force_N\n" + rows(LINE, T, X, F), "utf-8"),
    "LibreOffice": ("Zeit [s],Weg [mm],Kraft [N]\n" + rows(T, X, F, dec=",", quote='"'), "utf-8"),
}
LANGUAGES = {
    "Polish": ("Czas [s];Przemieszczenie [mm];Siła [N];Rezystancja [Ω]\n" + european(T, X, F, R), "utf-8"),
    "Dutch": ("Tijd (s);Verplaatsing (mm);Kracht (N);Weerstand (kOhm)\n" + european(T, X, F, R / 1e3), "utf-8"),
    "Portuguese": ("Tempo (s);Deslocamento (mm);Força (N);Resistência (Ohm)\n" + european(T, X, F, R), "cp1252"),
    "Spanish": ("Tiempo (s);Extensión (mm);Carga (N);Resistencia (ohm)\n" + european(T, X, F, R), "cp1252"),
    "Italian": ("Tempo (s);Corsa (mm);Carico (N);Resistenza (Ohm)\n" + european(T, X, F, R), "cp1252"),
    "Japanese": ("時間[秒],変位[mm],荷重[N],抵抗[Ω]\n" + rows(T, X, F, R), "utf-8"),
    "Japanese, Shift-JIS": ("時間(秒),伸び(mm),荷重(N),抵抗値(kΩ)\n" + rows(T, X, F, R / 1e3), "cp932"),
    "Korean": ("시간(s),변위(mm),하중(N),저항(Ω)\n" + rows(T, X, F, R), "utf-8"),
    "Korean, EUC": ("시간(초),변위(mm),하중(N)\n" + rows(T, X, F), "cp949"),
    "Chinese, Big5": ("時間(s),位移(mm),荷重(N)\n" + rows(T, X, F), "big5"),
    "Chinese, GBK": ("时间(s),位移(mm),负荷(N),电阻(kΩ)\n" + rows(T, X, F, R / 1e3), "gbk"),
}
EVERY = TESTERS | LOGGERS | PROGRAMS | LANGUAGES


@pytest.mark.parametrize("name", EVERY)
def test_it_is_read_right_without_an_option(tmp_path: Path, name: str) -> None:
    text, encoding = EVERY[name]
    (tmp_path / "lab.csv").write_bytes(text.encode(encoding))
    found = import_csv(tmp_path / "lab.csv", Wish(40.0)).recording
    assert found.time_s == pytest.approx(T, abs=1e-3)
    assert len(found.channels) >= 2
    assert found.has("resistance_ohm") == any(word in text for word in ("Ohm", "ohm", "Ω", "OHM"))
    for channel, values in CHANNELS.items():
        if found.has(channel):
            np.testing.assert_allclose(found[channel], values, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    "strain", ["strain_mm_mm", "Strain mm/mm", "strain_mm_per_mm", "Strain mm mm", "Strain (mm/mm)"]
)
def test_a_length_by_a_length_is_no_length(tmp_path: Path, strain: str) -> None:
    (tmp_path / "lab.csv").write_text(f"time_s,{strain},force_N\n" + rows(T, X / 40, F))
    assert import_csv(tmp_path / "lab.csv", Wish(40.0)).recording["displacement_mm"] == pytest.approx(X)


@pytest.mark.parametrize("strain", ["Strain [mm]/[mm]", "Strain (mm) / (mm)", "time_s_ms"])
def test_half_a_unit_is_none(tmp_path: Path, strain: str) -> None:
    others = "t_s" if "time" not in strain else "x_mm"
    (tmp_path / "lab.csv").write_text(f"{others},{strain},force_N\n" + rows(T, T, F))
    with pytest.raises(UserError, match="cannot be read as one"):
        import_csv(tmp_path / "lab.csv", Wish(40.0))


@pytest.mark.parametrize(
    "name", ["Course", "Charge", "Charge (C)", "Last", "Last cycle (N)", "Strain.1", "Disp Digits"]
)
def test_what_is_another_thing_without_its_unit(tmp_path, name):
    (tmp_path / "lab.csv").write_text(f"Time (s),Position (mm),{name}\n" + rows(T, X, [7.0] * COUNT))
    assert set(import_csv(tmp_path / "lab.csv", Wish(40.0)).recording.channels) == {"displacement_mm"}


@pytest.mark.parametrize(
    "name", ["Siła maksymalna [N]", "Snelheid [mm]", "最大荷重 [N]", "최대하중(N)", "応力 [N]", "入力 [N]"]
)
def test_words_about_a_quantity_are_not_the_quantity(tmp_path: Path, name: str) -> None:
    (tmp_path / "lab.csv").write_text(f"t [s],x [mm],{name}\n" + rows(T, X, F), encoding="utf-8")
    assert not import_csv(tmp_path / "lab.csv", Wish(40.0)).recording.has("force_N")


def test_cells_that_moved_are_seen_beside_a_remark_and_decimal_commas(tmp_path: Path) -> None:
    """The column beyond the last one is text there, and its numbers have commas."""
    lines = european(T, X, F).split("\n")
    lines[20] += ";washed"
    lines[30] = f"3,0;{lines[30]}"
    (tmp_path / "lab.csv").write_text("\n".join(["Zeit [s];Weg [mm];Kraft [N]", *lines]))
    with pytest.raises(UserError, match=r"row 32: .* must be a number, got '3.*more than 3 cells"):
        import_csv(tmp_path / "lab.csv", Wish(40.0))
    assert import_csv(tmp_path / "lab.csv", Wish(40.0, drop_bad=True)).dropped == 1


def autoranged(names: str) -> str:
    cells = [(R / 1e3, "kOhm") if n < 40 else (R / 1e6, "MOhm") for n in range(COUNT)]
    values, units = [values[n] for n, (values, _) in enumerate(cells)], [unit for _, unit in cells]
    return f"{names}\n" + rows(LINE, stamps("%Y-%m-%d %H:%M:%S.%f"), values, units, ["AUTO"] * COUNT, F)


@pytest.mark.parametrize("name", ["Resistance", "Value"])
def test_the_unit_beside_each_number_of_a_multimeter_is_its_own(tmp_path: Path, name: str) -> None:
    """From where its range changed, megaohms were read as kiloohms."""
    (tmp_path / "dmm.csv").write_text(autoranged(f"No.,Time,{name},Unit,Range,Force [N]"))
    done = import_csv(tmp_path / "dmm.csv", Wish())
    np.testing.assert_allclose(done.recording["resistance_ohm"], R)
    assert done.taken["resistance"].startswith(f"column 3 '{name}' in kΩ (column 4 'Unit'): 47 kΩ read as 47 000 Ω")
    assert done.details["columns"]["resistance"]["units"] == "Unit"


@pytest.mark.parametrize(
    ("names", "units", "said"),
    [
        ("No.,Time,Value [kOhm],Unit,Range,Force [N]", {}, "kΩ, as header says"),
        ("No.,Time,R,Unit,Range,Force [N]", {"resistance": "kohm"}, "kΩ, as --resistance-unit says"),
    ],
)
def test_a_unit_beside_a_number_that_is_another_than_the_one_of_all_is_refused(tmp_path: Path, names, units, said):
    (tmp_path / "dmm.csv").write_text(autoranged(names))
    with pytest.raises(UserError, match=f"row 42: Unit must be {said}, got 'MOhm'"):
        import_csv(tmp_path / "dmm.csv", Wish(units=units))


def test_a_letter_beside_a_number_that_may_be_no_unit_of_it_is_none(tmp_path: Path) -> None:
    (tmp_path / "lab.csv").write_text("t [s],x,State,F [N],Flag\n" + rows(T, X, ["N"] * COUNT, F, ["s"] * COUNT))
    recording = import_csv(tmp_path / "lab.csv", Wish(40.0, units={"displacement": "mm"})).recording
    np.testing.assert_allclose(recording["displacement_mm"], X)
