"""The words that exports use for time, displacement, force and resistance, and which of these a column's name means.

English, German and Chinese; the plain words of French, Italian and Spanish; and those of the testers: Standardweg and
Standardkraft (testXpert), Extension and Load (Bluehill), Crosshead (MTS), Digital Position (WaveMatrix).
"""

from __future__ import annotations

import re
import unicodedata

from testbench.importing.vocabulary.relative import ratio_by_formula, ratio_by_words

# Roles a column can have, and the quantities its unit may be of. A displacement in % is a strain, a strain in mm a
# displacement: there the unit decides.
ROLES: dict[str, tuple[str, ...]] = {
    "time": ("time",),
    "displacement": ("length",),
    "strain": ("ratio",),
    "force": ("force",),
    "resistance": ("resistance",),
    "conductance": ("conductance",),
    "relative": ("ratio",),
    "relative_change": ("ratio",),
    "temperature": ("temperature",),
}
STRETCH = {"displacement", "strain"}

# Whole words, without accents: English, and French, Italian and Spanish. Of those, none that is another thing in
# English or German (course: of a knit, charge: a batch).
_WHOLE = {
    "time": "time elapsed timestamp clock seconds runtime temps tempo tiempo",
    "displacement": "displacement displ disp extension elongation crosshead position pos stroke travel deflection "
    "extensometer deplacement allongement spostamento corsa allungamento desplazamiento alargamiento deformation",
    "strain": "strain",
    "force": "force load loadcell effort forza carico fuerza carga",
    "resistance": "resistance resistor res resistenza resistencia",
    "conductance": "conductance conduttanza conductancia",
    "temperature": "temperature temp temperatura",
}
# Parts of a word, for German, which joins its words, and Chinese, which does not part them.
_PARTS = {
    "time": ("zeit", "时间", "时刻", "時間", "時刻"),
    "displacement": (
        "weg",
        "verschiebung",
        "verlängerung",
        "verlaengerung",
        "traverse",
        "verformung",
        "位移",
        "行程",
        "伸长",
        "伸長",
        "变形",
        "變形",
    ),
    "strain": ("dehnung", "应变", "應變"),
    "force": ("kraft", "试验力", "試驗力", "拉力", "载荷", "載荷", "荷重", "负荷", "負荷", "力"),
    "resistance": ("widerstand", "电阻", "電阻"),
    "conductance": ("leitwert", "电导", "電導"),
    "temperature": ("temperatur", "温度", "溫度"),
}
_SYMBOLS = {
    "time": ("t", "T"),
    "displacement": ("x", "s", "u", "d", "dl", "Δl", "ΔL", "δ"),
    "strain": ("ε", "eps", "epsilon"),
    "force": ("F", "f"),
    "resistance": ("R", "r"),
    "conductance": ("G",),
    "temperature": ("T", "ϑ", "θ"),
}
# A column with such a word is about the quantity, not the quantity itself. Rates, set points, extremes, counters.
_ABOUT = frozenset(
    [
        "rate",
        "speed",
        "velocity",
        "setpoint",
        "set",
        "command",
        "cmd",
        "commanded",
        "target",
        "demand",
        "reference",
        "max",
        "maximum",
        "min",
        "minimum",
        "peak",
        "break",
        "rupture",
        "yield",
        "std",
        "sd",
        "error",
        "limit",
        "count",
        "counter",
        "number",
        "index",
        "energy",
        "work",
        "stress",
        "modulus",
        "cycle",
        "cycles",
        "zyklus",
        "zyklen",
        "planned",
        "noise",
        "adc",
        "stiffness",
        "density",
        "shunt",
        "series",
        "vitesse",
        "velocita",
        "velocidad",
        "consigne",
        "contrainte",
        "maximale",
        "massimo",
        "massima",
        "maximo",
        "maxima",
    ]
)
_ABOUT_PARTS = (
    "geschwindigkeit", "soll", "zyklus", "bruch", "spannung", "maximal", "höchst",
    "应力", "速度", "速率", "循环", "次数", "最大", "最小", "设定", "目标", "编号",
    "應力", "循環", "次數", "設定", "目標", "編號",
)  # fmt: skip
# Of an index behind R: the resistance at rest, or another one of the circuit, and not the one that is measured.
_NOT_MEASURED = frozenset(["0", "o", "ref", "init", "initial", "rest", "shunt", "series", "load"])
# A strain that is not the nominal one along the sensor: of the length at the time, or across.
_NOT_NOMINAL = frozenset(["true", "log", "logarithmic", "hencky", "transverse", "lateral"])
_NOT_NOMINAL_PARTS = ("quer", "wahre", "logarithm", "hencky", "真", "对数", "對數", "横向", "橫向")
_NOT_ALONE = ("力矩", "动力", "動力", "应力", "應力")
_GENERIC = re.compile(
    r"^(ch(annel)?|kanal|ai|analog(ue)?[ _]?in(put)?|sensor|signal|value|wert|column|spalte|y|通道)?[ _#.:-]*\d*$",
    re.I,
)
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[^\W\d_]+")

CERTAIN, LIKELY, SYMBOL = 3, 2, 1


def words_of(name: str) -> list[str]:
    """The words of a name, lower case, without accents: ``axialForce_cell 2`` gives axial, force, cell."""
    plain = "".join(sign for sign in unicodedata.normalize("NFD", name) if not unicodedata.combining(sign))
    return [word.casefold() for word in _WORD.findall(plain)]


def roles_of(base: str, whole: str) -> dict[str, int]:
    """The roles that a name speaks of, with how plainly: `CERTAIN`, `LIKELY` or `SYMBOL`.

    Parameters
    ----------
    base : str
        The name without unit and without what stands in brackets behind it.
    whole : str
        The name without its unit.
    """
    formula = ratio_by_formula(whole) or ratio_by_formula(base)
    if formula:
        return {formula: CERTAIN}
    ratio = ratio_by_words(whole, words_of(whole))
    if ratio and not speaks_about(whole, ratio):
        return {ratio: LIKELY}
    if speaks_about(whole):
        return {}
    found: dict[str, int] = {}
    for role in _WHOLE:
        strength = max(_by_word(role, base, whole), _by_symbol(role, base))
        if strength and not (role == "strain" and _is_not_nominal(whole)):
            found[role] = strength
    strongest = max(found.values(), default=0)
    return {role: strength for role, strength in found.items() if strength == strongest}


def _by_word(role: str, base: str, whole: str) -> int:
    whole_words, parts = _WHOLE[role].split(), _PARTS[role]
    plain = base.strip().casefold()
    if plain in whole_words or plain in parts:
        return CERTAIN
    words = words_of(whole)
    if any(word in whole_words for word in words):
        return LIKELY
    text = whole.casefold()
    for other in _NOT_ALONE:
        text = text.replace(other, "")
    return LIKELY if any(part in text for part in parts) else 0


def _by_symbol(role: str, base: str) -> int:
    """A formula's letter alone, or with an index behind it (``t_R``, ``R_inner``, ``F1``)."""
    letter, index = _letter_and_index(base)
    if letter not in _SYMBOLS[role]:
        return 0
    return 0 if role == "resistance" and index.casefold() in _NOT_MEASURED else SYMBOL


def is_letter(base: str) -> bool:
    """Whether a name is a formula's letter, alone or numbered (``R``, ``R2``), with no word behind it."""
    letter, index = _letter_and_index(base)
    return (not index or index.isdecimal()) and any(letter in symbols for symbols in _SYMBOLS.values())


def _letter_and_index(base: str) -> tuple[str, str]:
    found = re.match(r"^([A-Za-zΔδεϑθ]+?)(?:[_ ](\w+)|(\d+))?$", base.strip())
    return (found[1], found[2] or found[3] or "") if found else ("", "")


def speaks_about(whole: str, role: str = "") -> bool:
    """Whether a name is of something derived: a rate, a set point, a maximum, a counter.

    The change rate of a resistance (电阻变化率) is its relative change, no change in time.
    """
    text = whole.casefold()
    rate = {"rate"} if role == "relative_change" else set()
    return bool((_ABOUT - rate) & set(words_of(whole))) or any(part in text for part in _ABOUT_PARTS)


def _is_not_nominal(whole: str) -> bool:
    """Whether a strain is another than the nominal one, on which every model here is built."""
    text = whole.casefold()
    return bool(_NOT_NOMINAL & set(words_of(whole))) or any(part in text for part in _NOT_NOMINAL_PARTS)


def is_generic(base: str) -> bool:
    """Whether a name says nothing (``Channel 3``, ``AI0``, empty): there, the unit alone tells the role."""
    return bool(_GENERIC.match(base.strip()))


REPEAT_WORDS = {"repeat", "repetition", "wiederholung", "pull", "run", "specimen", "probe", "cycle", "重复", "试样"}


def counts_repeats(base: str) -> bool:
    """Whether a name may number the repeats of a test."""
    return any(word in REPEAT_WORDS for word in words_of(base)) or base.strip() in REPEAT_WORDS
