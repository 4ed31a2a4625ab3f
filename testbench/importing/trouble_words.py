"""What a person must say before a file can be taken in, in one sentence for the command line."""

from __future__ import annotations

from collections.abc import Sequence

from testbench.importing.choice import FLAGS, UNIT_FLAGS, Choice, Trouble
from testbench.importing.layout import Column, Layout, described, shortened
from testbench.importing.vocabulary.laboratory_units import symbols, unit_of
from testbench.importing.vocabulary.roles import ROLES
from testbench.importing.wish import Wish

WORDS = {
    "relative": "relative resistance R/R0",
    "relative_change": "relative change (R-R0)/R0, or change R-R0",
}


def in_words(troubles: Sequence[Trouble], layout: Layout, first: Sequence[str]) -> str:
    """Troubles in one sentence for the command line, with their remedies.

    Parameters
    ----------
    troubles : sequence of Trouble
    layout : Layout
    first : sequence of str
        Cells of the first row of numbers, which are shown where there are no names.
    """
    text = "; ".join(map(_in_words, troubles))
    if not any(trouble.kind == "absent" for trouble in troubles):
        return text
    text += f"; {described(layout)}"
    if layout.header_row is None:
        text += (
            f" (row {layout.first_row}: {', '.join(f'{at} = {cell[:9]}' for at, cell in enumerate(first[:12], 1))})"
        )
    return text


def several(columns: Sequence[Column]) -> str:
    """``column 3 and column 4 both``, ``column 3, column 4 and column 5 all``."""
    *others, last = [column.label for column in columns]
    return f"{', '.join(others)} and {last} {'both' if len(columns) == 2 else 'all'}"


def unit_unknown(column: Column) -> str:
    """Why the unit of a column is not known, in words."""
    return (
        f"its unit {shortened(column.unit_text)!r} cannot be read as one"
        if column.unit_text
        else "the file does not say its unit"
    )


def _in_words(trouble: Trouble) -> str:
    role, flag = WORDS.get(trouble.role, trouble.role), FLAGS[trouble.role]
    columns = " and ".join(column.label for column in trouble.columns)
    if trouble.kind == "several":
        last = trouble.columns[-1].number
        return f"{several(trouble.columns)} fit {role}: say which, e.g. {flag} {last}" + (
            f" (and where a channel has a clock of its own, --time-of force={last})"
            if trouble.role == "time"
            else f" (or {flag} none)"
        )
    if trouble.kind == "unit":
        allowed = ", ".join(symbols(ROLES[trouble.role])) + (", date" if trouble.role == "time" else "")
        said = f"{role} ({columns}): {unit_unknown(trouble.columns[0])}; say {UNIT_FLAGS[trouble.role]} ({allowed})"
        if trouble.columns[0].unit_text and trouble.role != "time":
            said += f", or {flag} none where it is none"
        if role == "resistance" and unit_of(trouble.columns[0].unit_text, ("ratio",)):
            number = trouble.columns[0].number
            said += f", or --relative-resistance {number} (R/R0) or --relative-change {number} ((R-R0)/R0)"
        return said
    if trouble.kind.startswith("r0"):
        said = f"{role} ({columns}) needs the resistance at rest R0, which it is relative to: say --rest-ohm R0 in Ω"
        unknown = " (1 where nobody knows it: the resistance is then in units of R0)"
        return said + unknown if trouble.kind == "r0" else said
    if trouble.role == "time":
        return "no time found: say --time COL, or --rate-hz F where there is none"
    return (
        "no displacement found, nor force and resistance both: say --displacement COL or --strain COL "
        "(a name, or a number from 1)"
    )


def idle_words(choice: Choice, wish: Wish) -> str:
    """What a person said of what no column is taken for, in words, since it would be left out; or nothing."""
    alike = {role: {one for one in ROLES if UNIT_FLAGS[one] == UNIT_FLAGS[role]} for role in wish.units}
    idle = [UNIT_FLAGS[role] for role, those in alike.items() if not those & set(choice.taken)]
    idle += [f"--time-of {role}=" for role in wish.time_of if role not in choice.taken]
    if idle:
        taken = "; ".join(f"{role}: {one.column.label}" for role, one in choice.taken.items())
        return f"{idle[0]} is of what no column is taken for ({taken or 'none is'}); leave it out"
    if wish.rate_hz is not None and "time" in choice.taken:
        return (
            f"--rate-hz is of a file without times, and {choice.taken['time'].column.label} is taken for them; leave "
            "--rate-hz or --time out"
        )
    if wish.r0_ohm is not None and not any(role.startswith("relative") for role in choice.taken):
        return "--rest-ohm is R0 of a relative resistance, of which no column is taken; leave it out"
    return ""
