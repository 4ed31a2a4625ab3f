"""One cell of a header: the name, what stands in brackets behind it, and the unit, wherever it was written."""

from __future__ import annotations

import re
from dataclasses import dataclass

from testbench.importing.relative import ratio_by_formula
from testbench.importing.units import Unit, plain_text, unit_of, units_spelt
from testbench.importing.words import ROLES, STRETCH, is_generic, roles_of

_BRACKET = re.compile(r"^(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\)|\{([^{}]*)\}|<([^<>]*)>)\s*$", re.S)
_TAIL = re.compile(r"^(.*?)(?:\s*/\s*|\s+in\s+|\s*[,:;=]\s*|_|\s+)([^\s/,:;=_]+)$", re.S)
_STROKE = re.compile(r"^([^/,]+?)\s*[/,]\s*([^\s/,\d][^\s,]*)$")
_RATIOS = {role for role, quantities in ROLES.items() if quantities == ("ratio",)}
LONGEST = 300  # characters of a cell that are looked at; no name of a column is longer
_PER_CENT = re.compile(r"^(.*?)\s*([%‰])$", re.S)


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
        The roles that the name speaks of, with how plainly (`testbench.importing.words`).
    """

    text: str
    base: str
    whole: str
    unit_text: str
    roles: dict[str, int]

    @property
    def says_ratio(self) -> bool:
        """Whether the name is a formula (``dR/R0``), which has the unit 1 where no other is said."""
        return bool(ratio_by_formula(self.whole) or ratio_by_formula(self.base))

    @property
    def quantities(self) -> tuple[str, ...]:
        """The quantities that a unit of this column may be of; every one where the name says nothing."""
        roles = set(self.roles) | (STRETCH if STRETCH & set(self.roles) else set())
        if not roles:
            roles = set(ROLES) if is_generic(self.base) else set()
        # A change of the resistance may be in Ω; then it is neither a resistance nor relative to one.
        more = ("resistance",) if "relative_change" in roles else ()
        return tuple(dict.fromkeys([*(quantity for role in roles for quantity in ROLES[role]), *more]))

    def unit(self, unit_text: str) -> Unit | None:
        """The unit that `unit_text` means in a column of this name; None where it cannot be told."""
        return unit_of(unit_text, self.quantities) if unit_text else None


def read_heading(text: str) -> Heading:
    """Part a header cell: ``Kraft [N]``, ``Weg / mm``, ``time_ms``, ``Load(Cell 1:Load) (N)``, ``Zeit in s``."""
    plain = plain_text(text[:LONGEST]).strip("\"'").strip()
    whole, unit_text = _parted(plain)
    base = _without_brackets(whole)
    return Heading(text.strip(), base, whole, unit_text, roles_of(base, whole))


def _parted(plain: str) -> tuple[str, str]:
    """The name and the unit's text."""
    bracket = _BRACKET.match(plain)
    if bracket and bracket[1].strip():
        inside = next(part for part in bracket.groups()[1:] if part is not None).strip()
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


def _tail(plain: str) -> tuple[str, str]:
    """A unit behind a stroke, a comma, an underscore or a blank: one that suits the name before it."""
    for pattern in (_PER_CENT, _TAIL):
        found = pattern.match(plain)
        if found and found[1].strip() and not ratio_by_formula(plain):
            name = found[1].strip()
            quantities = read_heading(name).quantities if not is_generic(name) else ()
            if unit_of(found[2], quantities) is not None:
                return name, found[2]
    stroke = _STROKE.match(plain)
    if stroke and roles_of(stroke[1], stroke[1]) and not ratio_by_formula(plain):
        return stroke[1], stroke[2]  # a unit that we cannot read
    return plain, ""


def _without_brackets(name: str) -> str:
    """``Load(ElectroPuls (0,1):Load)`` is ``Load``; a formula in brackets stays."""
    if "/" in name or "Δ" in name:
        return name
    before = re.split(r"[(\[{<]", name, maxsplit=1)[0].strip()
    return before or name
