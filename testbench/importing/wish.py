"""What a person says about a foreign file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from testbench.importing.choice import NOT_THERE, Said
from testbench.importing.sheet import Hints


@dataclass(frozen=True)
class Wish:
    """What a person says about a foreign file; all else is read from it.

    Attributes
    ----------
    gauge_length_mm : float or None
        Needed where the file has a displacement or strain.
    columns : mapping of str to str
        By role (of `vocabulary.roles.ROLES`): the column's name, or its number from 1; ``none``: not there.
    units : mapping of str to str
        By role, in place of what the file says; ``date`` for a time of dates.
    rate_hz : float, optional
        Sampling rate of a file without a time column.
    time_of : mapping of str to str
        By role: the column of its own times, where the file has several clocks.
    r0_ohm : float, optional
        R0 of ``relative`` (R/R0) and ``relative_change`` ((R - R0)/R0).
    negate : frozenset of str
        Roles whose sign is turned.
    zero : mapping of str to (str or None)
        Roles that are counted from their first sample (None), or from a value in the file's unit (or with its own).
    repeat : int, optional
        Of several repeats in the file, this one.
    sort : bool
        Put rows in the order of time and drop repeated times.
    drop_bad : bool
        Leave out rows with a value that cannot be used.
    hints : Hints
        How the file is written.

    Examples
    --------
    >>> import testbench as tb
    >>> tb.Wish(gauge_length_mm=25, columns={"force": "Load"}, units={"force": "lbf"}).gauge_length_mm
    25
    """

    gauge_length_mm: float | None = None
    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    rate_hz: float | None = None
    time_of: Mapping[str, str] = field(default_factory=dict)
    r0_ohm: float | None = None
    negate: frozenset[str] = frozenset()
    zero: Mapping[str, str | None] = field(default_factory=dict)
    repeat: int | None = None
    sort: bool = False
    drop_bad: bool = False
    hints: Hints = field(default_factory=Hints)

    def said(self) -> Said:
        """What it says about columns."""
        return Said(self.columns, self.units, self.time_of, self.rate_hz is not None, self.r0_ohm is not None)

    def names(self) -> list[str]:
        """Columns that were given by name."""
        every = [*self.columns.values(), *self.time_of.values()]
        return [name for name in dict.fromkeys(every) if name != NOT_THERE and not name.strip().isdigit()]
