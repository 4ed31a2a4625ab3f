"""Units as laboratories write them, and the factor that brings each to ours (s, mm, N, ohm, S, 1, degC)."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

import numpy as np

from gcode.support.errors import UserError


@dataclass(frozen=True)
class Unit:
    """A unit of measurement.

    Attributes
    ----------
    quantity : str
        ``time``, ``length``, ``force``, ``resistance``, ``conductance``, ``ratio`` or ``temperature``.
    symbol : str
        As people write it: ``kΩ``.
    factor, offset : float
        Our value = `factor` x value + `offset`.
    """

    quantity: str
    symbol: str
    factor: float
    offset: float = 0.0

    def converted(self, values: np.ndarray) -> np.ndarray:
        """`values` in our unit of the quantity."""
        return values * self.factor + self.offset


OURS = {
    "time": "s",
    "length": "mm",
    "force": "N",
    "resistance": "Ω",
    "conductance": "S",
    "ratio": "1",
    "temperature": "°C",
}
STANDARD_GRAVITY = 9.80665

# quantity -> (symbol, factor, offset, spellings to the letter, spellings in any case). Where a capital changes the
# meaning (mN and MN, mΩ and MΩ, S and s), the spelling counts to the letter; what is in neither list is not read.
_TABLE: dict[str, tuple[tuple[str, float, float, str, str], ...]] = {
    "time": (
        (
            "s",
            1.0,
            0.0,
            "",
            "s sec secs second seconds sek sekunde sekunden secondes secondi seg segundos sn с сек 秒 초",
        ),
        ("ms", 1e-3, 0.0, "ms MS msec", "millis millisecond milliseconds millisekunde millisekunden мс 毫秒 ミリ秒"),
        ("µs", 1e-6, 0.0, "µs us usec", "micros microsecond microseconds mikrosekunde mikrosekunden 微秒"),
        ("ns", 1e-9, 0.0, "ns", "nanos nanosecond nanoseconds nanosekunde nanosekunden"),
        ("min", 60.0, 0.0, "", "min mins minute minutes minuten minuti minutos mm:ss m:ss мин 分 分钟 분"),
        ("h", 3600.0, 0.0, "h hr hrs", "hour hours stunde stunden heures ore horas hh:mm h:mm ч 小时"),
        ("d", 86_400.0, 0.0, "d", "days tage jours giorni días 天"),
    ),
    "length": (
        ("mm", 1.0, 0.0, "mm MM", "millimeter millimeters millimetre millimetres millimetri мм 毫米"),
        ("µm", 1e-3, 0.0, "µm um", "micron microns micrometer micrometre mikrometer 微米"),
        ("cm", 10.0, 0.0, "cm CM", "centimeter centimetre zentimeter см 厘米"),
        ("m", 1e3, 0.0, "m", "meter meters metre metres 米"),
        ("in", 25.4, 0.0, "in", "inch inches zoll pouces pollici pulgadas"),
        ("mil", 0.0254, 0.0, "", "mil mils thou"),
    ),
    "force": (
        ("N", 1.0, 0.0, "N", "newton newtons н 牛 牛顿 ニュートン"),
        ("mN", 1e-3, 0.0, "mN", "millinewton millinewtons 毫牛"),
        ("µN", 1e-6, 0.0, "µN uN", "mikronewton micronewton micronewtons"),
        ("cN", 1e-2, 0.0, "cN CN", "centinewton"),
        ("daN", 10.0, 0.0, "daN DaN", "decanewton dekanewton"),
        ("kN", 1e3, 0.0, "kN KN", "kilonewton kilonewtons кн 千牛"),
        ("gf", STANDARD_GRAVITY * 1e-3, 0.0, "g g-f", "gf gmf gram grams gramm gram-force pond 克"),
        ("kgf", STANDARD_GRAVITY, 0.0, "kg Kg kg-f kp KG", "kgf kilogram kilograms kilogramm kilopond кгс 千克 公斤"),
        ("lbf", 4.4482216152605, 0.0, "lb lbs lb-f", "lbf pound-force pounds"),
        ("ozf", 4.4482216152605 / 16, 0.0, "", "ozf ounce-force"),
    ),
    "resistance": (
        ("Ω", 1.0, 0.0, "Ω", "ohm ohms ohmios ом 欧 欧姆 オーム 옴"),
        ("mΩ", 1e-3, 0.0, "mΩ mohm mOhm", "milliohm milliohms 毫欧"),
        ("kΩ", 1e3, 0.0, "kΩ KΩ", "kohm kohms kohmios kiloohm kiloohms kilohm kilohms ком 千欧"),
        ("MΩ", 1e6, 0.0, "MΩ Mohm MOhm", "megaohm megaohms megohm megohms 兆欧"),
        ("GΩ", 1e9, 0.0, "GΩ", "gohm gigaohm gigaohms"),
    ),
    "conductance": (
        ("S", 1.0, 0.0, "S", "siemens"),
        ("mS", 1e-3, 0.0, "mS", "millisiemens"),
        ("µS", 1e-6, 0.0, "µS uS", "microsiemens mikrosiemens"),
        ("nS", 1e-9, 0.0, "nS", "nanosiemens"),
    ),
    "ratio": (
        ("1", 1.0, 0.0, "1 -", "mm/mm m/m in/in ohm/ohm ω/ω n/n"),
        ("%", 1e-2, 0.0, "%", "percent prozent pct"),
        ("‰", 1e-3, 0.0, "‰", "promille permille"),
        ("µε", 1e-6, 0.0, "µε uε µm/m um/m", "ue microstrain ustrain µstrain"),
    ),
    "temperature": (
        ("°C", 1.0, 0.0, "C °C", "degc deg.c celsius grad 摄氏度"),
        ("K", 1.0, -273.15, "K", "kelvin"),
        ("°F", 5 / 9, -160 / 9, "F °F", "degf deg.f fahrenheit"),
    ),
}


def plain_text(text: str) -> str:
    """One spelling for signs that have several: full-width brackets, the two omegas, deltas and mus, ℃, R₀.

    Signs that mean something by their height (the ² of mm²) stay as they are; those that nobody sees are left out.
    """
    seen = (sign for sign in text if unicodedata.category(sign) != "Cf")
    kept = "".join(sign if sign in "²³" else unicodedata.normalize("NFKC", sign) for sign in seen)
    return kept.replace("μ", "µ").replace("∆", "Δ").replace("−", "-").strip()


def _spelt() -> tuple[dict[str, list[Unit]], dict[str, list[Unit]]]:
    exact: dict[str, list[Unit]] = {}
    loose: dict[str, list[Unit]] = {}
    for quantity, rows in _TABLE.items():
        for symbol, factor, offset, letters, any_case in rows:
            unit = Unit(quantity, symbol, factor, offset)
            for word in dict.fromkeys([plain_text(symbol), *(plain_text(word) for word in letters.split())]):
                exact.setdefault(word, []).append(unit)
            for word in any_case.split():
                loose.setdefault(plain_text(word).casefold(), []).append(unit)
    return exact, loose


_EXACT, _LOOSE = _spelt()


PREFIX = r"(?:[kKMmµunc]|[Kk]ilo|[Mm]ega|[Mm]illi|[Mm]i[ck]ro|[Cc]enti)"
_PREFIX = re.compile(rf"^({PREFIX})\s+(?=\S+$)")  # a blank behind the prefix: k Ohm, kilo Newton
_IN = re.compile(r"^in\s+(?=\S)")


def units_spelt(text: str) -> list[Unit]:
    """Every unit that `text` may be, at most one a quantity; empty when it is none."""
    word = _IN.sub("", plain_text(text).strip("[](){}<>").strip().removesuffix("."))
    word = _PREFIX.sub(r"\1", word)
    found = {unit.quantity: unit for unit in _LOOSE.get(word.casefold(), [])}
    found |= {unit.quantity: unit for unit in _EXACT.get(word, [])}
    return list(found.values())


def unit_of(text: str, quantities: tuple[str, ...]) -> Unit | None:
    """The unit that `text` is, if it is one of these quantities (of exactly one of them), else None."""
    fitting = [unit for unit in units_spelt(text) if unit.quantity in quantities]
    return fitting[0] if len(fitting) == 1 else None


def symbols(quantities: tuple[str, ...]) -> list[str]:
    """The units of these quantities, ours first."""
    return [row[0] for quantity in quantities for row in _TABLE[quantity]]


def given_unit(option: str, text: str, quantities: tuple[str, ...]) -> Unit:
    """The unit that a person named.

    Raises
    ------
    UserError
        If it is none of these quantities.
    """
    unit = unit_of(text, quantities)
    if unit is None:
        raise UserError(f"{option} must be one of {', '.join(symbols(quantities))}, got {text!r}")
    return unit


def number_in_words(value: float) -> str:
    """A number as people write it: thousands apart, no more digits than it has (``439 377``, ``0.0125``)."""
    if not np.isfinite(value):
        return str(value)
    if value and not 1e-4 <= abs(value) < 1e12:
        return f"{value:.6g}"
    digits = max(0, 9 - max(0, len(str(int(abs(value))))))
    text = f"{value:z,.{digits}f}".replace(",", " ")
    return text.rstrip("0").rstrip(".") if "." in text else text


def conversion(value: float, unit: Unit) -> str:
    """``439.377 kΩ read as 439 377 Ω``; only the value where the unit is ours already."""
    ours = OURS[unit.quantity]
    if unit.symbol == ours:
        return f"{number_in_words(value)} {ours}".removesuffix(" 1")
    read = float(unit.converted(np.asarray(value)))
    return f"{number_in_words(value)} {unit.symbol} read as {number_in_words(read)} {ours}".removesuffix(" 1")
