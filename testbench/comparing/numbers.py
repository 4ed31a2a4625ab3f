"""Numbers as people write them: no exponents, as many digits as are known, one unit for one quantity."""

from __future__ import annotations

import math

PREFIXES = {
    "ohm": ((1e6, "MΩ"), (1e3, "kΩ"), (1.0, "Ω")),
    "S": ((1.0, "S"), (1e-3, "mS"), (1e-6, "µS"), (1e-9, "nS")),
}
SPELT = {"1": "", "degC": "°C", "C": "°C"}
SMALL, LARGE = 1e-4, 1e7  # outside, a power of ten stands behind the number
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def plain(value: float, digits: int = 3) -> str:
    """A number with `digits` significant digits: ``966``, ``1100``, ``0.036``, ``2.1·10⁻⁷``."""
    if value == 0 or not math.isfinite(value):
        return "0" if value == 0 else str(value)
    if not SMALL <= abs(value) < LARGE:
        return in_powers(f"{value:.{digits - 1}e}")
    return _fixed(value, digits - 1 - _power(value, digits))


def in_powers(number: str) -> str:
    """``2e-05`` as ``2·10⁻⁵``; a number without an exponent as it is."""
    mantissa, exponent, power = number.partition("e")
    return f"{mantissa}·10{str(int(power)).translate(SUPERSCRIPTS)}" if exponent else number


def _power(value: float, digits: int) -> int:
    """Power of ten of the first digit, once a number is rounded to so many: 9.996 has three as 10.0."""
    return int(f"{value:.{digits - 1}e}".partition("e")[2])


def _fixed(value: float, decimals: int) -> str:
    """Rounded to so many decimals; to tens or hundreds where `decimals` is negative."""
    return f"{round(value, decimals) + 0.0:.{max(decimals, 0)}f}"  # and no "-0.0"


def span(low: float, high: float, unit: str = "", between: str = "to") -> str:
    """``966 to 1100 s``: both ends with the decimals that the larger one needs for three digits."""
    largest = max(abs(low), abs(high))
    tail = f" {unit}" if unit else ""
    if largest == 0 or not SMALL <= largest < LARGE:
        return f"{plain(low)} {between} {plain(high)}{tail}"
    decimals = 2 - _power(largest, 3)
    return f"{_fixed(low, decimals)} {between} {_fixed(high, decimals)}{tail}"


def in_unit(value: float, unit: str) -> tuple[float, str]:
    """Factor and name of the unit that a value of this size is best read in: ``(1e-3, "kΩ")`` for 4700 ohm."""
    if unit not in PREFIXES:
        return 1.0, SPELT.get(unit, unit)
    sizes = PREFIXES[unit]
    size, name = next((one for one in sizes if abs(value) >= one[0]), sizes[-1])
    return 1 / size, name


def in_words(value: float, unit: str) -> str:
    """``4.70 kΩ``."""
    factor, name = in_unit(value, unit)
    return f"{plain(factor * value)} {name}".strip()


def with_error(value: float, error: float, unit: str) -> str:
    """``5.80 ± 0.20 N``: the error with two digits, the value to the same decimal."""
    factor, name = in_unit(value or error, unit)
    value, error = factor * value, factor * error
    tail = f" {name}" if name else ""
    if not (math.isfinite(error) and error > 0) or not SMALL <= max(abs(value), error) < LARGE:
        return f"{plain(value)} ± {plain(error, 2)}{tail}"
    decimals = min(1 - _power(error, 2), 6)
    return f"{_fixed(value, decimals)} ± {_fixed(error, decimals)}{tail}"


def allowed(low: float, high: float, unit: str) -> str:
    """The range that a parameter may lie in: ``0.1 to 3000 s``, ``1 nS to 100 S``."""
    ends = [(end, *in_unit(end, unit)) if end else (0.0, 1.0, "") for end in (low, high)]
    texts = [bare(factor * end) for end, factor, _ in ends]
    names = [name for _, _, name in ends]
    if names[0] in ("", names[1]):
        return f"{texts[0]} to {texts[1]} {names[1]}".strip()
    return f"{texts[0]} {names[0]} to {texts[1]} {names[1]}".strip()


def bare(value: float) -> str:
    """Without trailing zeros: as it was declared, or as it stands at an axis."""
    text = plain(value, 3)
    return text.rstrip("0").rstrip(".") if "." in text and "·" not in text else text


def over_noise(error: float, floor: float) -> float:
    """How many noise floors an error is; a very large number where there is no noise."""
    return error / max(floor, 1e-300)
