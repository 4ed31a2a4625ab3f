"""The test of `exports`, as devices, loggers and programs of many kinds and countries write it."""

from __future__ import annotations

import datetime
from dataclasses import dataclass, field

import numpy as np

from tests.testbench.importing.exports import EXTENSION_MM, FORCE_N, RESISTANCE_OHM, TIME_S

T, X, F, R = TIME_S, EXTENSION_MM, FORCE_N, RESISTANCE_OHM
KOHM, LBF_N, GF_N, INCH_MM = R / 1e3, 4.4482216152605, 9.80665e-3, 25.4
BEGIN = datetime.datetime(2026, 3, 14, 9, 59, 30, 250_000)
MOMENTS = [BEGIN + datetime.timedelta(milliseconds=round(1e3 * time_s)) for time_s in T]
NUMBERS = [str(number) for number in range(1, len(T) + 1)]
NOTHING = [""] * len(T)
ALL, XF = ("displacement_mm", "force_N", "resistance_ohm"), ("displacement_mm", "force_N")
Cells = np.ndarray | list[str]


@dataclass(frozen=True, eq=False)
class Export:
    """A file, what is in it, and what a person must say of it."""

    data: bytes
    channels: tuple[str, ...]
    wish: dict[str, object] = field(default_factory=dict)


def table(*columns: Cells, separator: str = ",", decimal: str = ".", quote: str = "", end: str = "\n") -> str:
    """Rows of cells, numbers with nine digits behind the decimal sign."""
    cells = [
        [f"{quote}{value:.9f}{quote}".replace(".", decimal) for value in column]
        if isinstance(column, np.ndarray)
        else column
        for column in columns
    ]
    return "".join(separator.join(row) + end for row in zip(*cells, strict=True))


def moments(form: str, digits: int = 3) -> list[str]:
    """The moments in a form of `strftime`, in which %f is of so many digits."""
    return [moment.strftime(form.replace("%f", f"{moment.microsecond:06d}"[:digits])) for moment in MOMENTS]


def german(*columns: Cells, separator: str = ";") -> str:
    return table(*columns, separator=separator, decimal=",")


def export(text: str, *channels: str, encoding: str = "utf-8", **wish: object) -> Export:
    return Export(text.encode(encoding), channels or ALL, wish)


def before_each(stamps: list[str], text: str) -> str:
    """Lines with the stamp of a serial monitor before each; the first line came with the second."""
    lines = text.splitlines(keepends=True)
    return "".join(stamp + line for stamp, line in zip([stamps[0], *stamps], lines, strict=True))


MS = [str(round(1e3 * time_s)) for time_s in T]
LVM = (
    "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nMulti_Headings\tNo\n"
    "X_Columns\tOne\nTime_Pref\tRelative\nDate\t2026/03/14\nTime\t09:59:30.25\n***End_of_Header***\t\n\t\n"
    "Channels\t3\t\t\t\nSamples\t600\t600\t600\t\nY_Unit_Label\tmm\tN\tOhm\t\nX_Dimension\tTime\tTime\tTime\t\n"
    "X0\t0.0E+0\t0.0E+0\t0.0E+0\t\nDelta_X\t0.1\t0.1\t0.1\t\n***End_of_Header***\t\t\t\t\n"
    "X_Value\tPosition\tForce\tResistance\tComment\n"
)
TESTERS = {
    "Bluehill, results and a row of units": export(
        '"Results Table 1"\n"","Maximum Load [N]"\n"1","6.8"\n"Mean","6.8"\n"Standard deviation","-----"\n\n'
        '"Specimen 1"\n"Time","Extension","Load","Resistance"\n"(s)","(mm)","(N)","(kOhm)"\n'
        + table(T, X, F, KOHM, quote='"')
    ),
    "Bluehill, settings above": export(
        "Specimen label,K3\nWidth,25.0,mm\nLength,40.0,mm\nTest start time,14/03/2026 09:58:57\n\n"
        "Time,Extension,Load,Tensile strain,Tensile stress\n(s),(mm),(N),(%),(MPa)\n"
        + table(T, X, F, X / 0.4, F / 30),
        *XF,
    ),
    "pounds and inches": export("Time,Extension,Load\n(sec),(in),(lbf)\n" + table(T, X / INCH_MM, F / LBF_N), *XF),
    "mils and gmf": export("Time (sec),Travel (mils),Load (gmf)\n" + table(T, X / 0.0254, F / GF_N), *XF),
    "capitals": export("TIME,STROKE,LOAD,RES\nSEC,MM,KN,KOHM\n" + table(T, X, F / 1e3, KOHM)),
    "testXpert II": export(
        '"Prüfzeit";"Standardweg";"Standardkraft";"Widerstand"\n"s";"mm";"N";"kOhm"\n' + german(T, X, F, KOHM),
        encoding="cp1252",
    ),
    "testXpert III": export(
        "Specimen 1\r\nTest time\tStandard travel\tStandard force\tResistance\r\ns\tmm\tN\tkΩ\r\n"
        + table(T, X, F, KOHM, separator="\t", end="\r\n"),
        encoding="utf-16",
    ),
    "TestWorks": export(
        "MTS793|BTW|ENU|1|2|.|/|:|1|0|0|A\n\nData Header:\t\tTime:\t12.39\tSec\t3/14/2026 9:58:57 AM\n"
        "Data Acquisition:\tDAQ\n\nCrosshead \tLoad \tTime \nmm\tN\ts\n" + table(X, F, T, separator="\t"),
        *XF,
    ),
    "Trapezium": export(
        '"Test Mode:","Single"\n"Test Date","2026/03/14"\n"","1 _ 1","1 _ 1","1 _ 1"\n"","Time","Force","Stroke"\n'
        '"","sec","N","mm"\n' + table(NOTHING, T, F, X),
        *XF,
    ),
    "Mark-10": export(
        "Mark-10 IntelliMESUR\nDate: 03/14/2026\n\nReading #\tLoad (gF)\tTravel (mm)\tTime (s)\n"
        + table(NUMBERS, F / GF_N, X, T, separator="\t"),
        *XF,
    ),
    "catman": export(
        "HBM_CATMANEASY_DATAFILE_5.0\nTime  1 - default sample rate\tWeg\tKraft\ns\tmm\tN\n"
        + german(T, X, F, separator="\t"),
        *XF,
        encoding="latin-1",
    ),
    "a texture analyser": export("Force (g),Distance (mm),Time (sec)\n" + table(F / GF_N, X, T), *XF),
    "a push that is a pull": export(
        "Time (s),Load (N),Travel (mm)\n" + table(T, -F, -X), *XF, negate=frozenset({"force", "displacement"})
    ),
}
PROGRAMS = {
    "LabVIEW .lvm": export(LVM + table(T, X, F, R, separator="\t")),
    "LabVIEW .lvm, German": export(LVM.replace("Separator\t.", "Separator\t,") + german(T, X, F, R, separator="\t")),
    "LabVIEW .lvm without times": export(LVM + table(NOTHING, X, F, R, separator="\t"), rate_hz=10.0),
    "LabVIEW time since 1904": export(
        "Timestamp (s)\tPosition (mm)\tForce (N)\n" + table(3_856_327_137.25 + T, X, F, separator="\t"), *XF
    ),
    "MATLAB writetable": export("Time_s_,Displacement_mm_,Force_N_,R_kOhm_\n" + table(T, X, F, KOHM)),
    "MATLAB timetable": export(
        "Time,Disp_mm,Force_N,R_ohm\n" + table([f"{time_s:.1f} sec" for time_s in T], X, F, R)
    ),
    "MATLAB comment": export(
        "%t x F\n" + table(T, X, F, separator=" "), *XF, units={"time": "s", "displacement": "mm", "force": "N"}
    ),
    "numpy.savetxt": export("# time_s disp_mm force_N res_ohm\n" + table(T, X, F, R, separator=" ")),
    "pandas with an index": export(",time_s,disp_mm,force_N,res_ohm\n" + table(NUMBERS, T, X, F, R)),
    "R": export('"","time.s","disp.mm","force.N","R.kOhm"\n' + table([f'"{one}"' for one in NUMBERS], T, X, F, KOHM)),
    "sep=": export("sep=;\nZeit [s];Weg [mm];Kraft [N]\n" + german(T, X, F), *XF),
    "fixed width": export(
        "   Elapsed Time    Crosshead Position    Load Cell\n            (s)                  (mm)          (N)\n"
        + "".join(f"{t:15.3f} {x:21.6f} {f:12.6f}\n" for t, x, f in zip(T, X, F, strict=True)),
        *XF,
    ),
    "the names on every page": export(
        "".join(
            "Time (s),Extension (mm),Load (N)\n" + table(T[at : at + 60], X[at : at + 60], F[at : at + 60])
            for at in range(0, 600, 60)
        ),
        *XF,
    ),
    "samples twice": export(
        "Time (s),Extension (mm),Load (N)\n" + table(*(np.repeat(one, 2) for one in (T, X, F))), *XF, sort=True
    ),
    "statistics below": export(
        "Time (s),Extension (mm),Load (N)\n" + table(T, X, F) + "\nMaximum,6,6.8\nMean,3,3.4\n", *XF, drop_bad=True
    ),
    "UTF-16 without its mark": export(
        "Time (s)\tExtension (mm)\tLoad (N)\n" + table(T, X, F, separator="\t"), *XF, encoding="utf-16-le"
    ),
}
LOGGERS = {
    "Keithley buffer": export(
        "Index,Reading,Unit,Range Digits,Force (N),Date,Time,Fractional Seconds\n"
        + table(
            NUMBERS, R, ["Ohm"] * len(T), NUMBERS, F, moments("%m/%d/%Y"), moments("%H:%M:%S"), moments("0.%f", 6)
        ),
        "force_N",
        "resistance_ohm",
        columns={"resistance": "Reading"},
    ),
    "Graphtec": export(
        "Vendor,Graphtec\nSampling,100ms\nData\nNumber,Date&Time,ms,CH1,CH2\nNO.,Time,ms,mm,N\n"
        + table(NUMBERS, moments("%Y/%m/%d %H:%M:%S"), moments("%f"), [f"+  {x:.6f}" for x in X], F),
        *XF,
    ),
    "BenchVue": export(
        "Keysight BenchVue\nInstrument:,34465A\nStart:,3/14/2026 9:58:57 AM\n\n"
        "Sample,Date,Time,2W Resistance (Ohm),Force (N)\n"
        + table(NUMBERS, moments("%m/%d/%Y"), moments("%I:%M:%S.%f %p"), R, F),
        "force_N",
        "resistance_ohm",
    ),
    "a scanner": export(
        "Name:,scan\nTotal Channels:,2\nChannel,Name,Function,Range,Resolution\n101,sensor,Res 2W,100k,5.5\n"
        "102,cell,DCV,1,5.5\n\nStart Action:,Immediately\n\nScan,Time,101 (OHM),102 (N)\n"
        + table(NUMBERS, moments("%m/%d/%Y %H:%M:%S:%f"), R, F),
        "force_N",
        "resistance_ohm",
    ),
    "a meter that changes its range": export(
        "Time (s),Value,Unit,Force (N)\n"
        + table(
            T,
            [f"{r / 1e3:.6f}" if r > 4e5 else f"{r:.3f}" for r in R],
            ["kOhm" if r > 4e5 else "Ohm" for r in R],
            F,
        ),
        "force_N",
        "resistance_ohm",
    ),
    "PuTTY": export(
        "=~=~=~= PuTTY log 2026.03.14 09:58:57 =~=~=~=\nms,disp_mm,force_N,res_ohm\n" + table(MS, X, F, R)
    ),
    "Arduino with stamps": export(
        before_each(moments("%H:%M:%S.%f -> "), "ms,disp_mm,force_N,res_ohm\n" + table(MS, X, F, R))
    ),
    "CoolTerm with stamps": export(
        before_each(moments("%Y-%m-%d %H:%M:%S.%f "), "disp_mm,force_N,res_ohm\n" + table(X, F, R))
    ),
    "an ESP that begins": export(
        "ets Jan  8 2013,rst cause:1, boot mode:(3,7)\n\nload 0x4010f000, len 3456, room 16 \ntail 0\nHX711 ready\n"
        "millis,disp_mm,force_g,res_ohm\n" + table(MS, X, F / GF_N, R)
    ),
    "micros that begin anew": export(
        "micros,disp_mm,force_N\n" + table([str((round(1e6 * t) - 3_000_000) % 2**32) for t in T], X, F), *XF
    ),
    "names in the cells": export(
        "".join(f"t={t:.1f} s\tx={x:.9f} mm\tF={f:.9f} N\n" for t, x, f in zip(T, X, F, strict=True)), *XF
    ),
    "units in the cells": export(
        "Time,Extension,Load\n"
        + "".join(f"{t:.1f} s,{x:.9f} mm,{f:.9f} N\n" for t, x, f in zip(T, X, F, strict=True)),
        *XF,
    ),
    "conductance": export("t (s);x (mm);F (mN);G (µS)\n" + german(T, X, 1e3 * F, 1e6 / R), encoding="latin-1"),
    "a divider and what came of it": export(
        "time_s,disp_mm,force_N,V_out (V),R_sensor (kOhm),R_ref (kOhm)\n"
        + table(T, X, F, 3.3 * R / (R + 1e4), KOHM, 0 * R + 10)
    ),
    "relative change": export(
        "time_s,strain_pct,dR_R0_pct\n" + table(T, X / 0.4, 100 * (R / R[0] - 1)),
        "displacement_mm",
        "resistance_ohm",
        r0_ohm=float(R[0]),
    ),
}
CLOCKS: dict[str, Cells] = {
    "Time (min)": T / 60,
    "t/h": T / 3600,
    "Clock": moments("%H:%M:%S.%f"),
    "Zeit ": moments("%H:%M:%S:%f"),
    "Time ": moments("%I:%M:%S.%f %p"),
    "Elapsed": [f"00:{t // 60:02.0f}:{t % 60:04.1f}" for t in T],
    "ISO": moments("%Y-%m-%dT%H:%M:%S.%fZ"),
    "basic ISO": moments("%Y%m%dT%H%M%S.%f"),
    "a name of a file": moments("%Y%m%d_%H%M%S_%f"),
    "with a zone": moments("%Y-%m-%d %H:%M:%S.%f+01:00"),
    "German": moments("%d.%m.%Y %H:%M:%S.%f"),
    "ctime": moments("%a %b %d %H:%M:%S.%f 2026"),
    "mail": moments("%a %d %b %Y %H:%M:%S.%f +0100"),
    "American": moments("%b %d 2026 %I:%M:%S.%f %p"),
    "English": moments("%d/%m/%Y %H:%M:%S.%f"),
}
LANGUAGES = {
    "French": ("Temps (secondes);Déplacement (mm);Effort (N);Résistance électrique (kΩ)", "utf-8"),
    "French, Latin-1": ("Temps / s;Allongement / mm;Charge / N;Résistance / kOhm", "latin-1"),
    "Spanish": ("Tiempo (seg);Desplazamiento (mm);Fuerza (N);Resistencia (kohm)", "cp1252"),
    "Italian": ("Tempo [s];Spostamento [mm];Forza [N];Resistenza [kohm]", "utf-8-sig"),
    "Portuguese": ("Tempo (s);Deslocamento (mm);Força (N);Resistência (kΩ)", "utf-8"),
    "Polish": ("Czas [s];Wydłużenie [mm];Siła [N];Rezystancja [kOhm]", "cp1250"),
    "Russian": ("Время, с;Деформация, мм;Усилие, Н;Сопротивление, кОм", "cp1251"),
    "Turkish": ("Zaman (sn);Uzama (mm);Kuvvet (N);Direnç (kohm)", "cp1254"),
    "Japanese": ("時間(秒);変位(mm);荷重(N);抵抗(kΩ)", "cp932"),
    "Chinese": ("时间(秒);位移(毫米);力值(牛);阻值(千欧)", "gb18030"),
    "Chinese, UTF-16": ("时间;位移;负荷;电阻\ns;mm;N;kΩ", "utf-16"),
    "Korean": ("시간(초);변위(mm);하중(N);저항(kΩ)", "cp949"),
}
EXPORTS = {
    **TESTERS,
    **PROGRAMS,
    **LOGGERS,
    **{
        f"the time as {name}": export(f"{name},ext_mm,load_N\n" + table(cells, X, F), *XF)
        for name, cells in CLOCKS.items()
    },
    **{name: export(f"{head}\n{german(T, X, F, KOHM)}", encoding=code) for name, (head, code) in LANGUAGES.items()},
}
