"""A file as a table of cells, whatever wrote it: text, Excel or TDMS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support.errors import UserError
from gcode.support.kinds import whole

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd

    from testbench.importing.layout import Layout

HEAD_ROWS = 200
APART = (",", ".", "'", "’", " ", "\u00a0", "\u202f")  # what parts thousands


@dataclass(frozen=True)
class Hints:
    """What a person said about how the file is written; None and empty are found by themselves.

    Attributes
    ----------
    separator, decimal, thousands, encoding : str or None
    sheet : str or None
        Of a workbook; of a TDMS file, the group.
    header_row, units_row : int or None
        Counting from 1; 0 for none.

    Examples
    --------
    >>> import testbench as tb
    >>> german = tb.Hints(separator=";", decimal=",")
    >>> tb.Wish(gauge_length_mm=25, hints=german).hints.decimal
    ','
    """

    separator: str | None = None
    decimal: str | None = None
    thousands: str | None = None
    encoding: str | None = None
    sheet: str | None = None
    header_row: int | None = None
    units_row: int | None = None

    def __post_init__(self) -> None:
        for name in ("separator", "decimal", "thousands", "encoding", "sheet"):
            if not isinstance(text := getattr(self, name), str | None):
                raise UserError(f"`{name}` must be a text, got {text!r}; leave it out where it is to be found")
        for name in ("header_row", "units_row"):
            if (row := getattr(self, name)) is not None:
                object.__setattr__(self, name, whole(f"`{name}` (counted from 1, 0: there is none)", row, 0))
        if self.decimal not in (None, ",", "."):
            raise UserError(
                f"`decimal` must be ',' or '.', got {self.decimal!r}; leave it out where it is to be found"
            )
        if self.separator is not None and (len(self.separator) != 1 or self.separator in '"\r\n'):
            raise UserError(
                f"`separator` must be one character between columns, such as ; or \\t, got {self.separator!r}"
            )
        if self.thousands is not None and (self.thousands not in APART or self.thousands == self.decimal):
            others = ", ".join(repr(sign) for sign in APART[:5] if sign != self.decimal)
            raise UserError(f"`thousands` must be one of {others}, got {self.thousands!r}")

    @property
    def decimal_said(self) -> str | None:
        """The decimal sign that was said: a point that parts thousands leaves the comma, and the other way round."""
        return self.decimal or {",": ".", ".": ","}.get(self.thousands or "")


@dataclass(frozen=True)
class Sheet:
    """A table of cells; the kinds of file fill in `body`.

    Attributes
    ----------
    path : Path
    head : sequence of rows of cells
        Its first `HEAD_ROWS` rows.
    layout : Layout
    decimal : str
    separator : str
        What parts the cells, names too; a tab, which nobody writes in one, where nothing does.
    details : dict
        How it was read; for the manifest and for people.
    """

    path: Path
    head: Sequence[Sequence[str]]
    layout: Layout
    decimal: str
    separator: str
    details: dict[str, Any]

    def body(self, numbers: Sequence[int]) -> pd.DataFrame:
        """Everything from the layout's first row on: the columns with these numbers (from 1), in any type."""
        raise NotImplementedError

    def blank(self, frame: pd.DataFrame) -> np.ndarray:
        """Which rows of columns that `body` gave are empty, as booleans of shape (n,)."""
        return frame.isna().all(axis=1).to_numpy(dtype=bool)
