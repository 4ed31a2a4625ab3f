"""The first lines of a foreign file as they stand there, with header, units and columns marked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from testbench.importing.sheet import Sheet

LINES = 30
CELL = 44  # characters of a cell that are shown


def raw_table(sheet: Sheet, roles: Mapping[int, str]) -> str:
    """HTML of the first lines: above each column its number and what, by number, it is taken for."""
    layout = sheet.layout
    width = max([len(layout.columns), *(len(row) for row in sheet.head[:LINES])], default=1)
    head = "".join(_head(number, roles.get(number, "")) for number in range(1, width + 1))
    rows = "".join(
        _row(number, cells, width, _kind(number, layout.header_row, layout.units_row, layout.first_row))
        for number, cells in enumerate(sheet.head[:LINES], 1)
    )
    return (
        f'<table class="raw"><caption class="quiet">The first {min(LINES, len(sheet.head))} lines</caption>'
        f"<thead><tr><th>line</th>{head}</tr></thead><tbody>{rows}</tbody></table>"
    )


def _head(number: int, role: str) -> str:
    return f'<th scope="col"{" class=taken" if role else ""}>{number}<br>{escape(role)}</th>'


def _kind(number: int, header: int | None, units: int | None, first: int) -> str:
    marks = {header: "names", units: "units"}
    if number in marks:
        return marks[number]
    return "above" if number < first else ""


def _row(number: int, cells: Sequence[str], width: int, kind: str) -> str:
    texts = list(cells)
    if kind == "above" and sum(map(bool, texts)) < width:
        whole = escape("  ".join(text for text in texts if text)[: 3 * CELL])
        return f'<tr class="above"><th scope="row">{number}</th><td colspan="{width}">{whole}</td></tr>'
    shown = "".join(f"<td>{escape(text[:CELL])}</td>" for text in texts + [""] * (width - len(texts)))
    label = {"names": " names", "units": " units"}.get(kind, "")
    return f'<tr class="{kind}"><th scope="row">{number}{label}</th>{shown}</tr>'
