"""The words that exports use for time, displacement, force and resistance, and which of these a column's name means.

English, German and Chinese; the plain words of French, Italian, Spanish, Portuguese, Dutch, Polish, Czech, Swedish,
Danish, Norwegian, Turkish, Russian, Japanese and Korean; and those of the testers: Standardweg and Standardkraft
(testXpert), Extension and Load (Bluehill), Crosshead (MTS), Digital Position (WaveMatrix), Distance (Exponent).
"""

from __future__ import annotations

import re
import unicodedata

from testbench.importing.vocabulary.relative import CHANGE_PARTS, CHANGE_WORDS, ratio_by_formula, ratio_by_words

# Roles a column can have, and the quantities its unit may be of. A displacement in % is a strain, a strain in mm a
# displacement: there the unit decides. A change of the resistance may be in Ω, too: then it is R - R0.
ROLES: dict[str, tuple[str, ...]] = {
    "time": ("time",),
    "displacement": ("length",),
    "strain": ("ratio",),
    "force": ("force",),
    "resistance": ("resistance",),
    "conductance": ("conductance",),
    "relative": ("ratio",),
    "relative_change": ("ratio", "resistance"),
    "temperature": ("temperature",),
}
STRETCH = {"displacement", "strain"}


def _words(text: str) -> tuple[str, ...]:
    return tuple(text.split())


# Whole words, without accents: English, and other languages that part their words. Of those, none that is another
# thing in English or German (course: of a knit, charge: a batch); such say something only beside a unit. So do
# letters in capitals, as some programs write every name.
_BESIDE_UNIT = {"course": "displacement", "charge": "force", "last": "force"}
_BESIDE_UNIT |= dict.fromkeys(("X", "S", "U", "DL"), "displacement")
_WHOLE = {
    "time": _words(
        "time elapsed timestamp timestamps epoch clock seconds runtime temps tempo tiempo tijd czas cas tid zaman "
        "время"
    ),
    "displacement": _words(
        "displacement displ disp extension ext elongation elong crosshead position pos stroke travel deflection "
        "distance extensometer deplacement allongement spostamento corsa allungamento desplazamiento alargamiento "
        "deformation deformazione deformacion деформация deslocamento alongamento verplaatsing verlenging "
        "przemieszczenie wydluzenie "
        "posunuti prodlouzeni forlangning forskjutning forlengelse forskyvning forlængelse uzama "
        "перемещение удлинение"
    ),
    "strain": _words("strain odksztalcenie"),
    "force": _words(
        "force load loadcell effort forza carico fuerza carga forca kracht sila kuvvet нагрузка усилие сила"
    ),
    "resistance": _words(
        "resistance resistor resist res fres resistenza resistencia weerstand rezystancja opor odpor "
        "resistans motstand modstand direnc сопротивление"
    ),
    "conductance": _words("conductance conduttanza conductancia condutancia konduktancja"),
    "temperature": _words("temperature temp temperatura temperatuur"),
}
# Parts of a word, for German, which joins its words, and Chinese, Japanese and Korean, which do not part them.
_PARTS = {
    "time": _words("zeit 时间 时刻 時間 時刻 시간"),
    "displacement": _words(
        "weg verschiebung verlängerung verlaengerung längenänderung laengenaenderung traverse verformung "
        "位移 行程 伸长 伸長 变形 變形 変位 伸び ストローク 변위 연신"
    ),
    "strain": _words("dehnung 应变 應變 ひずみ 歪み 변형률"),
    "force": _words("kraft 试验力 試驗力 拉力 载荷 載荷 荷重 负荷 負荷 力 하중 시험력"),
    "resistance": _words("widerstand 电阻 電阻 阻值 抵抗 저항"),
    "conductance": _words("leitwert 电导 電導 コンダクタンス 컨덕턴스"),
    "temperature": _words("temperatur 温度 溫度 온도"),
}
_SYMBOLS = {
    "time": _words("t T"),
    "displacement": _words("x s u d dl dL Δl ΔL δ"),
    "strain": _words("ε eps epsilon"),
    "force": _words("F f"),
    "resistance": _words("R r Rs Rp Rdc"),  # the last as LCR meters write them
    "conductance": _words("G"),
    "temperature": _words("T ϑ θ"),
}
# A column with such a word is about the quantity, not the quantity itself. Rates, set points, extremes, counters,
# changes, powers.
_ABOUT = _words(
    "rate speed velocity setpoint set command cmd commanded target demand reference planned max maximum min minimum "
    "peak break rupture yield std sd noise error limit digits count counter number index cycle cycles "
    "zyklus zyklen energy work stress modulus stiffness density adc shunt series ntc ptc rtd thermistor "
    "rms log ln lg inverse reciprocal per cumulative accumulated offset tare difference diff squared sqrt "
    "err sigma uncertainty tolerance resolution residual gradient integral derivative "
    "vitesse velocita velocidad velocidade consigne contrainte maximale massimo massima maximo maxima snelheid "
    "predkosc maksymalna maksymalne zadana zadane naprezenie"
) + tuple(CHANGE_WORDS)
_ABOUT_PARTS = CHANGE_PARTS + _words(
    "^ ² ³ √ ** geschwindigkeit soll zyklus bruch spannung maximal höchst "
    "应力 速度 速率 循环 次数 最大 最小 设定 目标 编号 應力 循環 次數 設定 目標 編號 "
    "応力 回数 番号 サイクル 破断 降伏 응력 속도 최대 최소 설정 목표 번호 횟수 사이클 파단 항복"
)
# But the change rate of a resistance (电阻变化率) is its relative change, no change in time; a displacement is a
# change, of a length; the time has no rate (``Time - default sample rate`` of catman is one); and a thermistor
# measures a temperature.
_CHANGE = {*CHANGE_WORDS, *CHANGE_PARTS}
_NONE_ABOUT = {
    "relative_change": {"rate", *_CHANGE},
    "displacement": _CHANGE,
    "strain": _CHANGE,
    "time": {"rate", "cumulative", "offset"},
    "temperature": {"ntc", "ptc", "rtd", "thermistor"},
}
# Of an index behind R: the resistance at rest, or another one of the circuit, and not the one that is measured.
_NOT_MEASURED = _words("0 o ref init initial rest shunt series load known fixed pullup pulldown div divider")
# A strain that is not the nominal one, on which every model here is built: of the length at the time, or across.
_NOT_NOMINAL = _words("true log logarithmic hencky transverse lateral")
_NOT_NOMINAL_PARTS = _words("quer wahre logarithm hencky 真 对数 對數 横 橫向 진변형 횡변형")
_NOT_ALONE = _words("力矩 动力 動力 应力 應力 圧力 压力 壓力 入力 出力")
_GENERIC = re.compile(
    r"^(ch(annel)?|kanal|(\w+/)?ai|analog(ue)?[ _]?in(put)?|sensor|signal|value|readings?|(mess)?wert|column|spalte|y"
    r"|通道)?[ _#.:-]*\d*[ _]*(ave(rage)?\.?|avg|mean)?$",
    re.I,
)
_STROKED = str.maketrans("łŁ", "lL")  # a letter of its own, not an accent
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[^\W\d_]+")

CERTAIN, LIKELY, SYMBOL = 3, 2, 1


def words_of(name: str) -> list[str]:
    """The words of a name, lower case, without accents: ``axialForce_cell 2`` gives axial, force, cell."""
    return [word.casefold() for word in _WORD.findall(_unaccented(name))]


def accented_words_in(text: str) -> set[str]:
    """Known words that are there as they are written in their language, by which its encoding can be told."""
    words = {word for word in re.findall(r"[^\W\d_]+", text.casefold()) if not word.isascii()}
    whole = {word for word in words if any(_unaccented(word) in known for known in _WHOLE.values())}
    return whole | {
        part for parts in _PARTS.values() for part in parts if not part.isascii() and part in text.casefold()
    }


def _unaccented(text: str) -> str:
    plain = "".join(sign for sign in unicodedata.normalize("NFD", text) if not unicodedata.combining(sign))
    return plain.translate(_STROKED)


def roles_of(base: str, whole: str) -> dict[str, int]:
    """The roles that a name may speak of, with how plainly: `CERTAIN`, `LIKELY` or `SYMBOL`.

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
    found: dict[str, int] = {}
    for role in _WHOLE:
        strength = max(_by_word(role, base, whole), _by_symbol(role, base))
        if strength and not speaks_about(whole, role):
            found[role] = strength
    return found


def role_beside_unit(base: str, whole: str) -> str:
    """The role of a name that says one only where a unit of it stands beside; empty where there is none such."""
    words = [*words_of(whole), _letter_and_index(base)[0]]
    found = [_BESIDE_UNIT[word] for word in words if word in _BESIDE_UNIT]
    return found[0] if found and not speaks_about(whole) else ""


def _by_word(role: str, base: str, whole: str) -> int:
    whole_words, parts = _WHOLE[role], _PARTS[role]
    plain = base.strip().casefold()
    if _unaccented(plain) in whole_words or plain in parts:
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
    return 0 if role == "resistance" and index.casefold().partition("_")[0] in _NOT_MEASURED else SYMBOL


def is_letter(base: str) -> bool:
    """Whether a name is a formula's letter, alone or numbered (``R``, ``R2``), with no word behind it."""
    letter, index = _letter_and_index(base)
    return (not index or index.isdecimal()) and any(letter in symbols for symbols in _SYMBOLS.values())


def _letter_and_index(base: str) -> tuple[str, str]:
    found = re.match(r"^([A-Za-zΔδεϑθ]+?)(?:[_ ](\w+)|(\d+))?$", base.strip())
    return (found[1], found[2] or found[3] or "") if found else ("", "")


def speaks_about(whole: str, role: str = "") -> bool:
    """Whether a name is of something derived: a rate, a set point, a maximum, a counter, a logarithm."""
    words, parts, none_about = set(_ABOUT), set(_ABOUT_PARTS), _NONE_ABOUT.get(role, set())
    if role == "strain":
        words, parts = words.union(_NOT_NOMINAL), parts.union(_NOT_NOMINAL_PARTS)
    has_word = not (words - none_about).isdisjoint(words_of(whole))
    return has_word or any(part in whole.casefold() for part in parts - none_about)


def is_generic(base: str) -> bool:
    """Whether a name says nothing (``Channel 3``, ``AI0``, empty): there, the unit alone tells the role."""
    return bool(_GENERIC.match(base.strip()))


REPEAT_WORDS = set(_words("repeat repetition wiederholung pull run test specimen sample probe cycle 重复 试样"))


def counts_repeats(base: str) -> bool:
    """Whether a name may number or name the repeats of a test."""
    return any(word in REPEAT_WORDS for word in words_of(base)) or base.strip() in REPEAT_WORDS
