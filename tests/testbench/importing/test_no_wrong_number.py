"""However rows are damaged, what is read of a file is what stood in it before, or nothing."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gcode.support.errors import UserError
from testbench.importing.wish import Wish
from tests.testbench.importing.exports import import_csv
from tests.testbench.importing.layouts import ROWS, TRUE

ROLES = ("time", "displacement", "force")
CHANNELS = ("displacement_mm", "force_N")
TRUTH = {tuple(float(TRUE[role][row]) for role in ROLES) for row in range(ROWS)}
WORDS = (
    "",
    "nan",
    "OL",
    "x",
    "1_0",
    "0x1F",
    "１２",
    "1e999",
    "#DIV/0!",
    "True",
    "'5'",
    '"',
    '"5',
    "9" * 320,
    "-",
    "\x00",
    "5%",
)

FORMS = (  # what stands above the cells, and in each: a number, alone or with its unit, or its name
    ([["t[s]", "x[mm]", "F[N]"]], "{0}"),
    ([["t", "x", "F"]], "{0}{2}"),
    ([], "{1}_{2}:{0}"),
)


@st.composite
def damaged(draw: st.DrawFn) -> str:
    """A table with a remark behind a row, a cell doubled in another, and in more one lost, exchanged or no number."""
    separator = draw(st.sampled_from([",", ";", "\t", "|", " "]))
    decimal = draw(st.sampled_from([".", ","])) if separator != "," else "."
    header, cell = draw(st.sampled_from(FORMS))
    texts = [[f"{TRUE[role][row]:.6f}".replace(".", decimal) for role in ROLES] for row in range(ROWS)]
    rows = [
        [cell.format(*both) for both in zip(texts, ("t", "x", "F"), ("s", "mm", "N"), strict=True)] for texts in texts
    ]
    for damages, cells in enumerate(draw(st.lists(st.sampled_from(rows), min_size=2, max_size=4, unique_by=id))):
        at = draw(st.integers(0, len(cells) - 1))
        kind = ("remark", "double", draw(st.sampled_from(["word", "lost", "exchanged"])))[min(damages, 2)]
        if kind == "word":
            cells[at] = draw(st.sampled_from(WORDS))
        elif kind == "double":
            cells.insert(at, cells[at])
        elif kind == "remark":
            cells.append(draw(st.sampled_from(["washed", "", decimal, '"'])))
        elif kind == "exchanged":
            cells[at], cells[0] = "?" + cells[0], cells[at]
        else:
            del cells[at]
    lines = [separator.join(cells) for cells in [*header, *rows]]
    return draw(st.sampled_from(["\n", "\r\n", "\r"])).join(lines) + "\n"


@settings(max_examples=30, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(damaged(), st.booleans(), st.booleans())
def test_no_row_is_read_that_nobody_wrote(text: str, drop_bad: bool, sort: bool) -> None:
    with tempfile.TemporaryDirectory() as folder, suppress(UserError):
        path = Path(folder) / "lab.csv"
        path.write_bytes(text.encode())
        done = import_csv(path, Wish(40.0, drop_bad=drop_bad, sort=sort))
        times = done.recording.time_s + done.time_offset_s
        found = zip(times, *(done.recording[channel] for channel in CHANNELS), strict=True)
        assert {tuple(round(float(value), 6) for value in row) for row in found} <= TRUTH
