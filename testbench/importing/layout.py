"""Which row of a table has the names, which the units, and where the numbers begin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import mode

from gcode.support.errors import UserError
from testbench.importing.vocabulary.headings import COMMENT, Heading, power_of_ten, read_heading
from testbench.importing.vocabulary.laboratory_units import units_spelt
from testbench.importing.vocabulary.notation import MISSING, is_value, unit_in

Rows = Sequence[Sequence[str]]
SHOWN = 60  # characters of a name in a message
TOP_ROWS = 50  # of numbers that tell how wide a table is
LABVIEW_TIME = "X_Value (Time) [s]"  # what X_Value is, a .lvm says in rows of its own
COMMENT_SIGNS = {"#", "%", "//"}  # of NumPy, MATLAB and others, in a cell of their own where blanks part them
LOOK_UP = 8  # filled rows above the numbers in which names and units are looked for


def shortened(text: str, length: int = SHOWN) -> str:
    """A name as messages show it."""
    return text if len(text) <= length else f"{text[: length - 1]}…"


@dataclass(frozen=True)
class Column:
    """One column as the file names it.

    Attributes
    ----------
    number : int
        Counting from 1.
    heading : Heading
    unit_text : str
        From the header or the units row; both, with a stroke between them, where they differ.
    unit_from : str
        ``header`` or ``row 2``; empty where no unit was written.
    """

    number: int
    heading: Heading
    unit_text: str
    unit_from: str

    @property
    def label(self) -> str:
        """``column 3 'Kraft'``."""
        text = shortened(self.heading.text)
        return f"column {self.number} {text!r}" if text else f"column {self.number}"


@dataclass(frozen=True)
class Layout:
    """Where things are in a table; rows count from 1 as an editor does.

    Attributes
    ----------
    header_row, units_row : int or None
    first_row : int
        The first row of numbers.
    columns : tuple of Column
    """

    header_row: int | None
    units_row: int | None
    first_row: int
    columns: tuple[Column, ...]


def find_layout(
    rows: Rows, wanted: Sequence[str] = (), header_row: int | None = None, units_row: int | None = None
) -> Layout | None:
    """Find names, units and numbers.

    Parameters
    ----------
    rows : sequence of rows of cells
        The top of the table.
    wanted : sequence of str
        Names that the header must have, as far as a person gave some.
    header_row, units_row : int, optional
        Where a person said they are; 0 for none.

    Returns
    -------
    Layout or None
        None where no numbers are found below the header.
    """
    named = header_row or row_with(rows, wanted)
    known = max(named or 0, units_row or 0)
    start = next((at for at in range(known, len(rows)) if is_data(rows[at])), None) if known else _longest_run(rows)
    if start is None:
        return None
    width = width_of(rows[start])
    header: int | None = named or None
    if header_row is None and not header:
        header = names_above(rows, start, width)
    if units_row is None:
        units_row = _units_between(rows, header, start, width)
    return Layout(header, units_row or None, start + 1, _columns(rows, header, units_row or None, start))


def misfit(rows: Rows, layout: Layout, whole_names: bool = False) -> str:
    """What is wrong where names or units do not stand over the numbers, cell by cell; empty where nothing is.

    A name too many (an unquoted comma in it) or too few (a first column of row numbers without a name) would shift
    the meaning of every column behind it. Where no name can hold what parts the columns (`whole_names`), one too many
    is that of a column at the end which nobody filled.
    """
    body = _numbers_of(rows, layout.first_row - 1)
    most, filled = max(map(len, body)), _usual_width(body)
    for what, row in (("names", layout.header_row), ("units", layout.units_row)):
        cells = _of_table(rows[row - 1], filled) if row else []
        if row and ((width_of(cells) > most and not whole_names) or filled > len(cells)):
            return f"row {row} has {width_of(cells)} {what}, the rows of numbers below it {filled} columns"
    return ""


def row_with(rows: Rows, wanted: Sequence[str]) -> int | None:
    """The first row that has all the wanted names, from 1."""
    for number, cells in enumerate(rows, 1) if wanted else ():
        have = {cell.strip() for cell in cells} | {read_heading(cell).base for cell in cells}
        if all(name in have for name in wanted):
            return number
    return None


def is_data(cells: Sequence[str]) -> bool:
    """Whether most of a row's filled cells are numbers, or dates and times."""
    filled = [cell for cell in cells if cell.strip()]
    good = count_numbers(filled)
    missing = sum(cell.strip().casefold() in MISSING for cell in filled)
    return good >= 1 and 2 * (good + missing) >= len(filled)


def width_of(cells: Sequence[str]) -> int:
    """Cells up to the last filled one."""
    return max((place for place, cell in enumerate(cells, 1) if cell.strip()), default=0)


def _of_table(cells: Sequence[str], width: int) -> Sequence[str]:
    """A row without the sign of a comment before it, and what stands beside a table of this width, behind a gap."""
    if width_of(cells) > width and cells[0].strip() in COMMENT_SIGNS:
        cells = cells[1:]
    return cells if cells[width : width + 1] != [""] else cells[:width]


def count_numbers(cells: Sequence[str]) -> int:
    """How many cells are numbers, or dates and times."""
    return sum(map(is_value, cells))


def words_in(cells: Sequence[str]) -> set[int]:
    """Places of the cells that are neither numbers nor missing."""
    return {
        place
        for place, cell in enumerate(cells)
        if not count_numbers([cell]) and cell.strip().casefold() not in MISSING
    }


def _numbers_of(rows: Rows, start: int) -> list[Sequence[str]]:
    """The first rows of numbers of a table; remarks between them are none."""
    return [row for row in rows[start : start + TOP_ROWS] if is_data(row)]


def _usual_width(body: Rows) -> int:
    """How wide most rows of numbers are; a wider one among them is two that ran together, or has a cell too many."""
    return mode(map(width_of, body))


def _longest_run(rows: Rows) -> int | None:
    """Where the longest run of rows of numbers begins; blank rows and remarks do not end it, other tables do."""
    best: int | None = None
    best_length, begin, length = 0, 0, 0
    for place, cells in enumerate(rows):
        if not width_of(cells):
            continue
        if length and _is_alike(cells, rows[begin]):
            length += 1
        elif not (length and _goes_on(rows, begin, place)):
            begin, length = place, int(is_data(cells))
        if length > best_length:
            best, best_length = begin, length
    if best is None:
        return None
    first = rows[best]
    while best and _has_more_beside(rows[best - 1], first):
        best -= 1
    return best


def _has_more_beside(cells: Sequence[str], first: Sequence[str]) -> bool:
    """Whether a row is one of the table that begins below it, with something beside the table (``max``, ``6.8``)."""
    mine, width = cells[: width_of(first)], width_of(first)
    alike = words_in(mine) == words_in(first[:width]) and count_numbers(mine) == count_numbers(first)
    return width_of(cells) > width > 1 and alike


def _is_alike(cells: Sequence[str], first: Sequence[str]) -> bool:
    """Whether a row is one of numbers, as wide as the first of its run, with units in its cells if that has some."""
    if not is_data(cells) or abs(len(cells) - len(first)) > 1:
        return False
    return any(map(unit_in, cells)) == any(map(unit_in, first))


def _goes_on(rows: Rows, begin: int, place: int) -> bool:
    """Whether the run that begins at `begin` goes on below the row at `place`, which is none of it.

    It may be a remark of somebody, a row cut short, or the names above the run once more, with rows below them that
    have words where those of the run do. Names that are not above it are those of another table, and a line of what
    was set (``Width;25``) is no row of a run.
    """
    first = rows[begin]
    below = [cells for cells in rows[place:] if width_of(cells)]
    at = next((at for at, cells in enumerate(below) if _is_alike(cells, first)), None)
    if at is None or min(count_numbers(first), count_numbers(below[at])) < 2:
        return False
    names = [cells for cells in below[:at] if _speaks(cells)]
    again = all(cells in rows[:begin] for cells in names) and words_in(below[at]) == words_in(first)
    return again or not names


def _above(rows: Rows, start: int, width: int) -> list[int]:
    """Rows above the numbers that fit over them, the nearest first; blank rows are passed over.

    So are lines and remarks; above those, a row must speak to be one of names or units.
    """
    found: list[int] = []
    passed = False
    places = [place for place in range(start - 1, -1, -1) if width_of(rows[place])]
    for place in places[:LOOK_UP]:
        filled = sum(bool(cell.strip()) for cell in rows[place])
        if width_of(_of_table(rows[place], width)) > width + 1:
            break
        if _speaks(rows[place]) or (not passed and (2 * filled > width or width <= 2)):
            found.append(place)
        else:
            passed = True
    return found


def _speaks(cells: Sequence[str]) -> bool:
    """Whether a row with gaps is one of names or units all the same."""
    return _is_units(cells) or _names_in(cells) > 1


def _names_in(cells: Sequence[str]) -> int:
    """How many cells are names of what we look for, or have a unit behind them."""
    heads = [read_heading(cell) for cell in cells]
    return sum(bool(head.roles or (head.base and units_spelt(head.unit_text))) for head in heads)


def _is_units(cells: Sequence[str]) -> bool:
    """Whether half of a row are units, and not only such as a number or a dash may be, too (1, -)."""
    filled = [cell.strip() for cell in cells if cell.strip()]
    # In a row of units, s is no displacement.
    known = [cell for cell in filled if cell == "s" or (units_spelt(cell) and not read_heading(cell).base)]
    others = [cell for cell in filled if cell not in known]
    return bool(words_in(known)) and len(known) >= len(others) and _names_in(others) < 2


def names_above(rows: Rows, start: int, width: int) -> int | None:
    """The row (from 1) above the numbers with the most words for what we look for; the nearest of those."""
    places = [place for place in _above(rows, start, width) if not _is_units(rows[place])]
    meanings = {place: sum(bool(read_heading(cell).roles) for cell in rows[place]) for place in places}
    best = max(places, key=lambda place: (meanings[place], place), default=None)
    return None if best is None else best + 1


def _units_between(rows: Rows, header: int | None, start: int, width: int) -> int | None:
    """A row of units above the numbers; below a header, any row of words is one, if only one we cannot read.

    Above the header, a row of fewer cells is something else (``Unit,N``).
    """
    above = [place for place in _above(rows, start, width) if place >= (header or 0) or len(rows[place]) >= width]
    known = next((place for place in above if _is_units(rows[place]) and place + 1 != header), None)
    if known is not None:
        return known + 1
    between = [place for place in above if place >= (header or start)]
    return between[0] + 1 if header and len(between) == 1 else None


def _columns(rows: Rows, header: int | None, units_row: int | None, start: int) -> tuple[Column, ...]:
    width = _usual_width(_numbers_of(rows, start))
    names, units = (_of_table(rows[row - 1], width) if row else [] for row in (header, units_row))
    if ["X_Dimension", "Time"] in [list(cells[:2]) for cells in rows[: (header or 1) - 1]]:
        names = [name.replace("X_Value", LABVIEW_TIME) for name in names]
    if header and header < start and not _is_units(rows[header]):
        names = _with_parts(names, rows[header])
    width = max(width, width_of(names))
    cells = ((_cell(names, place), _cell(units, place)) for place in range(width))
    return tuple(column_named(number, *both, units_row) for number, both in enumerate(cells, 1))


def _with_parts(names: Sequence[str], below: Sequence[str]) -> list[str]:
    """Names, where merged ones are of several columns each with the part below it (``set Displacement``)."""
    filled = [bool(cell.strip()) for cell in below]
    parts = {
        place for place in range(1, len(below)) if all(filled[place - 1 : place + 1]) and not _cell(names, place)
    }
    joined, name = [], ""
    for place in range(max(len(names), len(below))):
        name = _cell(names, place) or (name if place in parts else "")
        joined.append(f"{_cell(below, place)} {name}".strip() if {place, place + 1} & parts else name)
    return joined


def _cell(cells: Sequence[str], place: int) -> str:
    return cells[place].strip() if place < len(cells) else ""


def column_named(number: int, name: str, below: str = "", units_row: int | None = None) -> Column:
    """A column by its name, and what the row of units has below it."""
    heading = read_heading(name)
    bare = COMMENT.sub("", below).strip("[](){}<> ").strip()
    if not bare or (heading.unit(heading.unit_text) and bare == "-"):
        return Column(number, heading, heading.unit_text, "header" if heading.unit_text else "")
    if heading.power or power_of_ten(bare):
        return Column(number, heading, f"{heading.unit_text} {bare}".strip(), f"header and row {units_row}")
    beside, under = heading.unit(heading.unit_text), heading.unit(bare)
    if beside is None or beside == under:
        return Column(number, heading, bare, f"row {units_row}")
    if not units_spelt(bare):
        return Column(number, heading, heading.unit_text, "header")
    return Column(number, heading, f"{heading.unit_text} | {bare}", f"header and row {units_row}")


def column_of(layout: Layout, text: str) -> Column:
    """The column that a person named, by its header cell, its name without unit, or its number from 1.

    Raises
    ------
    UserError
        If there is no such column, or the name stands twice.
    """
    for same in (
        [column for column in layout.columns if column.heading.text == text.strip()],
        [column for column in layout.columns if column.heading.base == text.strip()],
    ):
        if len(same) == 1:
            return same[0]
        if same:
            where = " and ".join(str(column.number) for column in same)
            raise UserError(f"the columns {where} are both called {text!r}; say which by its number")
    for column in layout.columns:
        if text.strip() == str(column.number):
            return column
    raise UserError(f"no column {text!r}; {described(layout)}")


def described(layout: Layout) -> str:
    """The columns of a file in words."""
    names = [shortened(column.heading.text) or f"(column {column.number})" for column in layout.columns]
    shown = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
    if layout.header_row is None:
        return f"no header was found above the {len(names)} columns, which are numbered from 1"
    return f"row {layout.header_row} has: {shown}"
