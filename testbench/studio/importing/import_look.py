"""What the import page shows of a file: how it is written, what its columns were taken for, what is still to say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from testbench.importing.choice import Choice
from testbench.importing.sheet import Sheet
from testbench.importing.vocabulary.laboratory_units import symbols
from testbench.importing.vocabulary.roles import ROLES
from testbench.studio.importing.import_form import NOT_THERE, Choices
from testbench.studio.importing.import_words import R0, TITLES

LINES = 30
CELL = 44  # characters of a cell that are shown
Seen = tuple["Sheet", "Choice", dict[str, str]]  # a file, what its columns mean, one value by role

SEPARATORS = {"": "found", ",": "comma", ";": "semicolon", "\t": "tab", "|": "bar", " ": "blanks"}
DECIMALS = {"": "found", ".": "point", ",": "comma"}
THOUSANDS = {"": "found", ",": "comma", ".": "point", "'": "apostrophe"}
ENCODINGS = {"": "found", "utf-8": "UTF-8", "cp1252": "Windows, Latin-1", "gb18030": "GBK", "shift_jis": "Shift-JIS"}


def look_at(choices: Choices) -> Seen:
    """The file, what its columns would be taken for, and by role one value as it would be read."""
    from testbench.importing.columns import previewed
    from testbench.importing.from_file import look

    sheet, choice = look(choices.path, choices.wish())
    return sheet, choice, previewed(sheet, choice, choices.wish().hints.thousands)


def described(sheet: Sheet) -> str:
    """How the file is written, in a sentence."""
    layout = sheet.layout
    header = f"names in row {layout.header_row}" if layout.header_row else "no row of names"
    units = f"units in row {layout.units_row}, " if layout.units_row else ""
    names: dict[str, dict[str, str]] = {"separator": SEPARATORS, "decimal": DECIMALS, "thousands": THOUSANDS}
    how = ", ".join(
        f"{what} {names.get(what, {}).get(str(value), value)}"
        for what, value in sheet.details.items()
        if value and not (what == "decimal" and value == ".")
    )
    return f"Found: {header}, {units}numbers from row {layout.first_row}; {how}"


def roles_by_number(choice: Choice) -> dict[int, str]:
    """By number of the column: what it was taken for."""
    found = {one.column.number: TITLES[role].lower() for role, one in choice.taken.items()}
    clocks = {one.clock.number: f"times of {role}" for role, one in choice.taken.items() if one.clock}
    return clocks | found


def column_options(sheet: Sheet) -> dict[str, str]:
    """The columns that a person can choose from, by their numbers."""
    names = {str(one.number): f"{one.number} · {one.heading.text}".rstrip(" ·") for one in sheet.layout.columns}
    return {NOT_THERE: "(not recorded)"} | names


def unit_options(role: str) -> dict[str, str]:
    """The units that a role can have."""
    units = {symbol: "as a ratio" if symbol == "1" else symbol for symbol in symbols(ROLES[role])}
    return units | ({"date": "dates"} if role == "time" else {})


def unit_key(choice: Choice, role: str) -> str | None:
    """The unit that a role was read in, as one of `unit_options`; None where it is not known."""
    taken = choice.taken.get(role)
    if taken is None or any(one.kind == "unit" and one.role == role for one in choice.troubles):
        return None
    return taken.unit.symbol if taken.unit else taken.short or "date"


def still_to_say(choice: Choice, role: str) -> str:
    """What a person must say about a role, in the page's words; empty when nothing."""
    from testbench.importing.trouble_words import several

    for one in choice.troubles:
        if one.role != role:
            continue
        if one.kind == "unit":
            text = one.columns[0].unit_text
            return (
                f"its unit {text!r} cannot be read: choose it"
                if text
                else "the file does not say the unit: choose it"
            )
        if one.kind == "several":
            own = "; where a channel has a clock of its own, see “Other quantities, and several clocks”"
            return f"{several(one.columns)} fit: choose one{own if role == 'time' else ''}"
        if one.kind.startswith("r0"):
            unknown = " (1 where nobody knows it)" if one.kind == "r0" else ""
            return f"fill in “{R0}”, the resistance it is relative to{unknown}"
        return (
            "choose its column, or fill in “Sampling rate / Hz”"
            if role == "time"
            else "choose its column, or those of force and resistance"
        )
    return ""


def raw_table(sheet: Sheet, roles: Mapping[int, str]) -> str:
    """HTML of the first lines: above each column its number and what, by number, it is taken for."""
    layout = sheet.layout
    width = max([len(layout.columns), *(len(row) for row in sheet.head[:LINES])], default=1)
    head = "".join(_head(number, roles.get(number, "")) for number in range(1, width + 1))
    kinds: dict[int | None, str] = dict.fromkeys(range(1, layout.first_row), "above")
    kinds |= {layout.header_row: "names", layout.units_row: "units"}
    rows = "".join(
        _row(number, cells, width, kinds.get(number, "")) for number, cells in enumerate(sheet.head[:LINES], 1)
    )
    return (
        f'<table class="raw"><caption class="quiet">The first {min(LINES, len(sheet.head))} lines</caption>'
        f"<thead><tr><th>line</th>{head}</tr></thead><tbody>{rows}</tbody></table>"
    )


def _head(number: int, role: str) -> str:
    return f'<th scope="col"{" class=taken" if role else ""}>{number}<br>{escape(role)}</th>'


def _row(number: int, cells: Sequence[str], width: int, kind: str) -> str:
    texts = list(cells)
    if kind == "above" and sum(map(bool, texts)) < width:
        whole = escape("  ".join(text for text in texts if text)[: 3 * CELL])
        return f'<tr class="above"><th scope="row">{number}</th><td colspan="{width}">{whole}</td></tr>'
    shown = "".join(f"<td>{escape(text[:CELL])}</td>" for text in texts + [""] * (width - len(texts)))
    label = f" {kind}" if kind in ("names", "units") else ""
    return f'<tr class="{kind}"><th scope="row">{number}{label}</th>{shown}</tr>'
