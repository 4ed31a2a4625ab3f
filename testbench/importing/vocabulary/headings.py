"""One cell of a header: the name, what stands in brackets behind it, and the unit, wherever it was written."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from testbench.importing.vocabulary.laboratory_units import PREFIX, Unit, plain_text, unit_of, units_spelt
from testbench.importing.vocabulary.relative import ratio_by_formula
from testbench.importing.vocabulary.roles import ROLES, STRETCH, is_generic, role_beside_unit, roles_of

_BRACKET = re.compile(
    r"^(.*?)[\s_]*(?:\[([^\[\]]*)\]|\(([^()]*)\)|\{([^{}]*)\}|<([^<>]*)>)((?:\s+[\w#][^\[\](){}<>]*)?)\s*$", re.S
)
_TAIL = re.compile(
    rf"^(.*?)(?:\s*/\s*|\s+in\s+|[\s_]+per[\s_]+|\s*[,:;=.]\s*|_|\s+)((?:{PREFIX}[\s_]+)?[^\s/,:;=._]+\.?)$", re.S
)
_STROKE = re.compile(r"^([^/,]+?)\s*[/,]\s*([^\s/,\d][^\s,]*)$")
_RATIOS = {role for role, quantities in ROLES.items() if "ratio" in quantities}
LONGEST = 300  # characters of a cell that are looked at; no name of a column is longer
_JOINED = re.compile(r"^(.*[^\W\d_A-Z])([A-Z]\w*)$")  # forceN, timeMs
_PER_CENT = re.compile(r"^(.*?)\s*([%‰])$", re.S)
_BEFORE = re.compile(r"^([%‰]|(?:per ?cent|prozent|pct)(?=[\s_]))[\s_]*(?:of\s+)?(?=\S)", re.I)  # % strain
_MADE = re.compile(r"\.\.([^.]+)\.$")  # R makes Load..N. of Load (N), and MATLAB Load_N_
_TWICE = re.compile(r"(?:(?<=[^\W\d])\.|(?<=[)\]])[._])\d{1,3}$")  # of names that stand twice, in pandas and R
_COUNTED = re.compile(r"(?<=[^\W\d])[_ ][1-9]\d{0,2}$")  # time_s_2
COMMENT = re.compile(r"^(?:#+|//+)\s*(?=\S)")
_HIGH = "[⁰¹²³⁴-⁹⁻]"
_TIMES = "(?:kilo|mega|milli|mi[ck]ro|centi|tenths?|hundredths?|thousandths?|zehntel|hundertstel|tausendstel)"
_POWERS = (  # whether the numbers are to be multiplied or were, nobody can tell
    # x1000, *0.001, x1k
    rf"(?<=\S)\s*(?:(?<![A-Za-z])x|[×*·÷])\s*(?:10+(?![\d.])(?:\^?[-+]?\d+|{_HIGH}+)?|1[kKM]\b|0[.,]0*1\b)",
    r"(?<=\S)\s*/\s*10{2,}\b",  # /1000
    rf"\b10(?:(?:\^|\*\*)\s*[-+−]?\d+|{_HIGH}+)",  # 10^3, 10**-3, 10³
    r"\b(?:\d+[eE][-+]?|(?<!\d)[eE][-+])\d+\b",  # 1e3, E+3
    rf"(?i:\b{_TIMES}\b)(?!\s+\w)",  # kilo (Ohm), but no kilo ohms
    r"(?<=\s)[(\[]?[kM][)\]]?(?=\s*[(\[])|[(\[][kM][)\]](?=\s*\w)",  # k (Ohm), (k) Ohm
    r"(?:(?<=[\s/(\[{<])|^)10+(?=\s*[^\W\d]+[\])}>]*$)",  # 1000 before a unit at the end
    r"^10+\s*(?:x\b|[×*·])(?=\s*\S)",  # 100 x dR/R0
)
_POWER = re.compile("|".join(_POWERS))


@dataclass(frozen=True)
class Heading:
    """What a header cell says.

    Attributes
    ----------
    text : str
        The cell as it was written.
    base : str
        The name without its unit and without brackets.
    whole : str
        The name without its unit.
    unit_text : str
        The unit as it was written; empty where none is.
    roles : dict of str to int
        The roles that the name speaks of, with how plainly (`testbench.importing.vocabulary.roles`).
    power : str
        A power of ten beside name or unit (``x1000``), with which no unit can be told; empty where none is.
    """

    text: str
    base: str
    whole: str
    unit_text: str
    roles: dict[str, int]
    power: str = ""

    @property
    def says_ratio(self) -> bool:
        """Whether the name is a formula (``dR/R0``), which has the unit 1 where no other is said."""
        return bool(ratio_by_formula(self.whole) or ratio_by_formula(self.base))

    @property
    def quantities(self) -> tuple[str, ...]:
        """The quantities that a unit of this column may be of; every one where the name says nothing."""
        roles = set(self.roles) or {role_beside_unit(self.base, self.whole)} - {""}
        if not roles and is_generic(self.base):
            roles = set(ROLES)
        roles |= STRETCH if STRETCH & roles else set()
        every = dict.fromkeys(quantity for role in roles for quantity in ROLES[role])
        return ("ratio",) if self.says_ratio else tuple(every)

    def unit(self, unit_text: str) -> Unit | None:
        """The unit that `unit_text` means in a column of this name; None where it cannot be told."""
        return unit_of(unit_text, self.quantities) if unit_text else None


def read_heading(text: str) -> Heading:
    """Part a header cell: ``Kraft [N]``, ``Weg / mm``, ``time_ms``, ``Load(Cell 1:Load) (N)``, ``# Zeit in s``."""
    plain = COMMENT.sub("", plain_text(text[:LONGEST]).strip("\"'").strip())
    plain = _TWICE.sub("", _MADE.sub(r" (\1)", plain).rstrip("_").removesuffix("()"))
    power = power_of_ten(plain)
    whole, unit_text = _unit_in_front(plain.replace(power, "", 1).strip() if power else plain)
    base = _without_brackets(whole)
    if power:
        unit_text = f"{unit_text} {power}".strip()
    return Heading(text.strip(), base, whole, unit_text, roles_of(base, whole), power)


def power_of_ten(text: str) -> str:
    """The power of ten that a cell of names or units speaks of (``x1000``, ``10^3``); empty where it does not."""
    found = _POWER.search(text)
    return found[0].strip() if found else ""


def _unit_in_front(plain: str) -> tuple[str, str]:
    """As `_parted`; a unit may also stand before the name, which has one: behind ``% t/s``, the % is no unit."""
    before = _BEFORE.match(plain)
    if before is None:
        return _parted(plain)
    whole, unit_text = _parted(plain[before.end() :])
    if not unit_text:
        comment = before[0] == "%" and roles_of(whole, whole).keys() - _RATIOS  # of MATLAB, as in %t x F
        return whole, "" if comment else before[1]
    ratio = any(unit.quantity == "ratio" for unit in units_spelt(unit_text))
    return whole, f"{before[1]} {unit_text}" if ratio else unit_text


def _parted(plain: str) -> tuple[str, str]:
    """The name and the unit's text."""
    bracket = _BRACKET.match(plain)
    if bracket and bracket[1].strip():
        inside, behind = (part.strip() for part in bracket.groups()[1:] if part is not None)
        if bracket[1].rstrip().endswith("/"):
            name, above = _parted(bracket[1].rstrip("/ \t\n"))
            # Kraft / [N]; but in [mm]/[mm], it is the lower half of a unit.
            return (name, inside) if units_spelt(inside) and not (above or behind) else (plain, f"/{inside}")
        if behind:  # Time (s) Run #1; but of two units, none can be told
            whole, end = _tail(f"{bracket[1]} {behind}")
            return (whole, f"{inside} {end}".strip()) if units_spelt(inside) else _tail(plain)
        if _may_be_a_unit(inside, bracket[1]):
            return bracket[1].strip(), inside
        return plain, _tail(bracket[1])[1]
    if plain and units_spelt(plain) and not roles_of(plain, plain):
        return "", plain  # nothing but a unit: the unit is the name
    return _tail(plain)


def _may_be_a_unit(inside: str, name: str) -> bool:
    """Known units, and short words without sense to us: those are units too, which we cannot read."""
    if inside.isdigit():  # "Load (1)" numbers the cell, "Strain (1)" says that it is no percentage
        return inside == "1" and bool(_RATIOS & set(roles_of(name.strip(), name)))
    return bool(units_spelt(inside)) or (0 < len(inside) <= 6 and not re.search(r"\d|\s", inside))


@lru_cache(4096)  # the names before all ends are beginnings of one: without it, the ways through them would multiply
def _tail(plain: str) -> tuple[str, str]:
    """A unit behind a stroke, a comma, an underscore or a blank: one that suits the name before it.

    Behind another one (``strain_mm_mm``, ``Strain mm/mm``) it is the lower half of a unit.
    """
    for name, *ends in () if ratio_by_formula(plain) else _ends(plain):
        quantities = read_heading(name).quantities if not is_generic(name) else ()
        if end := _one_unit(ends, quantities):
            before, above = _tail(name)
            return (before, f"{above}/{end}") if above and not above.isdigit() else (name, end)
    if (counted := _COUNTED.search(plain)) and not ratio_by_formula(plain):
        before, end = _tail(plain[: counted.start()])
        if end:
            return f"{before}{counted[0]}", end
    stroke = _STROKE.match(plain)
    if stroke and roles_of(stroke[1], stroke[1]) and not ratio_by_formula(plain):
        return stroke[1], stroke[2]  # a unit that we cannot read
    return plain, ""


def _ends(plain: str) -> list[tuple[str, ...]]:
    """A name, and what behind it may be its unit; a number behind a blank counts columns (``Strain 1``).

    A capital that does but part the unit from the name (``timeMs``) may be a small letter.
    """
    found = [match for pattern in (_TAIL, _PER_CENT) if (match := pattern.match(plain))]
    ends = [one for one in found if not one[2].isdigit() or plain[one.end(1) : one.start(2)].strip("_. ")]
    parted: list[tuple[str, ...]] = [(one[1].strip(), one[2]) for one in ends if one[1].strip()]
    joined = _JOINED.match(plain)
    if joined and joined[2] != "In":  # of inputs
        parted.append((joined[1], joined[2], joined[2][0].lower() + joined[2][1:] if joined[2][1:] else ""))
    return parted


def _one_unit(ends: Sequence[str], quantities: tuple[str, ...]) -> str:
    """The end that is a unit of these quantities; empty where none is, or they are two different ones."""
    units = {unit: end for end in ends if (unit := unit_of(end, quantities))}
    return units.popitem()[1] if len(units) == 1 else ""


def unit_behind(name: str, quantities: tuple[str, ...]) -> str:
    """The unit of one of these quantities at the end of a name (``ext_mm``), but not in ``(tens of N)``."""
    ends = [ends for before, *ends in _ends(name) if not re.search(r"[(\[{<][^)\]}>]*$", before)]
    return next(filter(None, (_one_unit(one, quantities) for one in ends)), "")


def _without_brackets(name: str) -> str:
    """``Load(ElectroPuls (0,1):Load)`` is ``Load``; a formula in brackets stays."""
    if "/" in name or "Δ" in name:
        return name
    before = re.split(r"[(\[{<]", name, maxsplit=1)[0].strip()
    return before or name
