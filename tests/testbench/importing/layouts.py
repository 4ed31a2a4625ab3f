"""Files as testers, loggers and spreadsheets write them, written by us; and generated ones of the same kind."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass, field

import numpy as np
from hypothesis import strategies as st

from testbench.importing.vocabulary.laboratory_units import unit_of
from testbench.importing.vocabulary.roles import ROLES

ROWS = 12
TIME_S = np.round(np.linspace(0.0, 1.1, ROWS), 3)
TRUE = {
    "time": TIME_S,
    "displacement": np.round(2 + 3.7 * TIME_S, 6),
    "force": np.round(1.5 + 2.3 * TIME_S, 6),
    "resistance": np.round(439_377.0 - 1234.5 * TIME_S, 3),
    "temperature": np.round(21.5 + TIME_S, 3),
}
CHANNELS = {
    "displacement": "displacement_mm",
    "force": "force_N",
    "resistance": "resistance_ohm",
    "temperature": "temperature_C",
}
NAMES = {
    "time": ["Time", "Zeit", "Prüfzeit", "时间", "t", "Running Time", "Elapsed time", "time"],
    "displacement": ["Extension", "Standardweg", "Weg", "位移", "x", "Crosshead", "Displacement", "Traversenweg"],
    "force": ["Load", "Standardkraft", "Kraft", "力", "F", "Axial Force", "试验力", "force"],
    "resistance": ["Resistance", "Widerstand", "电阻", "R", "Sensor resistance"],
    "temperature": ["Temperature", "Temperatur", "温度"],
}
SPELLINGS = {
    "time": ["s", "sec", "ms", "min", "Sek", "seconds", "h", "us", "µs"],
    "displacement": ["mm", "µm", "cm", "m", "um", "in"],
    "force": ["N", "mN", "kN", "g", "kgf", "cN", "lbf"],
    "resistance": ["Ω", "kΩ", "MΩ", "ohm", "kOhm", "Ohm", "kohm", "MOhm", "mΩ"],
    "temperature": ["°C", "K", "°F", "degC"],
}
UNREADABLE = ["", "foo", "V", "MPa", "mV/V", "counts", "MN", "MOHM", "Ms", "a.u.", "x1000", "10^3", "1e-3"]
OF_ANOTHER_KIND = {"time": "N", "displacement": "kOhm", "force": "mm", "resistance": "N", "temperature": "mm"}
DECOYS = [("Cycle", ""), ("Note", ""), ("Max force", "N"), ("Force rate", "N/s"), ("Point", ""), ("Sollweg", "mm")]
TITLES = ["Specimen 1", '"Specimen 1"', "Instron 5543, knit 3", "Prüfung: Gestrick; Charge 7", "# exported"]
TITLES += ['"Remark: washed\ntwice"', '"Strip 2 wide', 'Strip 2" wide']  # line breaks and inches
FORMS = ["{name} [{unit}]", "{name} ({unit})", "{name}({unit})", "{name} / {unit}", "{name}, {unit}", "{name}_{unit}"]
FORMS += ["{name}\n({unit})", "{name} in {unit}", "# {name} [{unit}]"]
FORMS += ["{name}_({unit})", "{name}_{unit}_", "{name}..{unit}."]  # as MATLAB and R make names of them


@dataclass
class Written:
    """A generated file, the roles in it, and those whose unit it does not say, or not in a way that can be read."""

    data: bytes
    roles: list[str]
    unsaid: set[str] = field(default_factory=set)


@st.composite
def files(draw: st.DrawFn) -> Written:
    """A file of some layout, language and units; about a third have a unit that is missing or cannot be read."""
    others = draw(st.sets(st.sampled_from(["force", "resistance", "temperature"]), min_size=1))
    roles = draw(st.permutations(["time", "displacement", *sorted(others)]))
    spelt = {role: draw(st.sampled_from(SPELLINGS[role])) for role in roles}
    unsaid = set(draw(st.lists(st.sampled_from(roles), max_size=1))) if draw(st.integers(0, 2)) == 0 else set()
    shown = {
        role: draw(st.sampled_from([*UNREADABLE, OF_ANOTHER_KIND[role]])) if role in unsaid else spelt[role]
        for role in roles
    }
    heads = [(draw(st.sampled_from(NAMES[role])), shown[role]) for role in roles]
    separator = draw(st.sampled_from([",", ";", "\t", "|"]))
    quoted = draw(st.booleans())
    decimal = draw(st.sampled_from([".", ","])) if separator != "," or quoted else "."
    cells = [[_number(_in_unit(role, spelt[role])[row], decimal) for role in roles] for row in range(ROWS)]
    for place, decoy in enumerate(draw(st.lists(st.sampled_from(DECOYS), max_size=2, unique=True))):
        heads.append(decoy)
        for row in cells:
            row.append("ok" if decoy[0] == "Note" else str(place + 7))
    lines = draw(st.lists(st.sampled_from([*TITLES, f"Operator{separator}Meier"]), max_size=3))
    table = [*_header(draw, heads), *cells]
    lines += [""] * draw(st.integers(0, 1)) + _written(table, separator, quoted) + [""] * draw(st.integers(0, 2))
    return Written(_encoded(draw, lines), list(roles), unsaid)


def _header(draw: st.DrawFn, heads: list[tuple[str, str]]) -> list[list[str]]:
    """Names with their units behind them, or names and a row of units below."""
    if draw(st.booleans()):
        form = draw(st.sampled_from(FORMS))
        return [[form.format(name=name, unit=unit) if unit else name for name, unit in heads]]
    around = draw(st.sampled_from(["{}", "({})", "[{}]"]))
    return [[name for name, _ in heads], [around.format(unit) if unit else "" for _, unit in heads]]


def _in_unit(role: str, spelling: str) -> np.ndarray:
    unit = unit_of(spelling, ROLES[role])
    assert unit is not None
    return (TRUE[role] - unit.offset) / unit.factor


def _number(value: float, decimal: str) -> str:
    return np.format_float_positional(value, precision=13, trim="0").replace(".", decimal)


def _written(table: list[list[str]], separator: str, quoted: bool) -> list[str]:
    stream = io.StringIO()
    rule = csv.QUOTE_ALL if quoted else csv.QUOTE_MINIMAL
    csv.writer(stream, delimiter=separator, quoting=rule, lineterminator="\n").writerows(table)
    return stream.getvalue().removesuffix("\n").split("\n")


def _encoded(draw: st.DrawFn, lines: list[str]) -> bytes:
    """In any encoding that has all the signs of the file."""
    text = draw(st.sampled_from(["\n", "\r\n"])).join(lines)
    able = [name for name in ("utf-8", "utf-8-sig", "utf-16", "cp1252", "gbk") if _can(text, name)]
    return text.encode(draw(st.sampled_from(able)))


def _can(text: str, encoding: str) -> bool:
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return False
    return True
