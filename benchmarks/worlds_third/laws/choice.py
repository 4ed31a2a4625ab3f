"""One member of each family, drawn, from those that the caller allows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gcode.support.errors import UserError
from worlds_third.laws.families import FAMILIES, LAW_FAMILIES
from worlds_third.laws.law import Chosen, Law
from worlds_third.randoms import draw, stream

__all__ = ["Chosen", "Law", "choose_laws"]


def choose_laws(
    seed: int, only: Mapping[str, Sequence[str]] | None = None, leave_out: str | Sequence[str] | None = None
) -> dict[str, Chosen]:
    """A law of every family.

    Parameters
    ----------
    seed : int
        Of the sensor.
    only : mapping, optional
        Families restricted to some members.
    leave_out : str or sequence of str, optional
        Members that are not drawn, as ``"gent"`` or ``"drift:none"``.

    Raises
    ------
    UserError
        If a name is unknown or nothing is left of a family.
    """
    out = [leave_out] if isinstance(leave_out, str) else list(leave_out or [])
    _check(only or {}, out)
    return {family: _chosen(seed, family, _allowed(family, only or {}, out)) for family in FAMILIES}


def _chosen(seed: int, family: str, names: list[str]) -> Chosen:
    rng = stream(seed, f"law/{family}")
    name = names[int(rng.integers(len(names)))]
    law = FAMILIES[family][name]
    return Chosen(name, law, draw(rng, law.ranges))


def _allowed(family: str, only: Mapping[str, Sequence[str]], out: Sequence[str]) -> list[str]:
    names = [n for n in only.get(family, LAW_FAMILIES[family]) if n not in out and f"{family}:{n}" not in out]
    if not names:
        raise UserError(f"make_case: no law is left for {family}, it has {_listed(family)}; leave fewer out")
    return names


def _check(only: Mapping[str, Sequence[str]], out: Sequence[str]) -> None:
    asked = [f"{family}:{name}" for family, names in only.items() for name in names] + list(out)
    known = {f"{family}:{name}" for family, names in LAW_FAMILIES.items() for name in names}
    known |= {name for names in LAW_FAMILIES.values() for name in names}
    for family in only:
        if family not in FAMILIES:
            raise UserError(f"make_case: no family of laws {family!r}; there are {', '.join(FAMILIES)}")
    for name in asked:
        if name not in known:
            families = "; ".join(f"{family}: {_listed(family)}" for family in FAMILIES)
            raise UserError(f"make_case: no law {name!r}; there are {families}")


def _listed(family: str) -> str:
    return ", ".join(LAW_FAMILIES[family])
