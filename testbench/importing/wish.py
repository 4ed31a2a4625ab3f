"""What a person says about a foreign file."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, field

from gcode.support.errors import UserError
from gcode.support.kinds import flag, number, whole
from gcode.support.read_only import Unchanging
from testbench.importing.choice import NOT_THERE
from testbench.importing.sheet import Hints
from testbench.importing.vocabulary.roles import ROLES


@dataclass(frozen=True)
class Wish(Unchanging):
    """What a person says about a foreign file; all else is read from it.

    Attributes
    ----------
    gauge_length_mm : float or None
        Needed where the file has a displacement or strain.
    columns : mapping of str to str
        By role (of `vocabulary.roles.ROLES`): the column's name, or its number from 1; ``none``: not there.
    units : mapping of str to str
        By role, in place of what the file says; ``date``: the time column holds dates.
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
    repeat : int or str, optional
        Of several repeats or specimens in the file, this one, by its number or name.
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
    repeat: int | str | None = None
    sort: bool = False
    drop_bad: bool = False
    hints: Hints = field(default_factory=Hints)

    def leaves_out(self, roles: Set[str]) -> bool:
        """Whether one of these roles was said to be none."""
        return any(self.columns.get(role) == NOT_THERE for role in roles)

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("columns", "units", "time_of", "zero"):
            _check_by_role(name, getattr(self, name), or_none=name == "zero")
        if not isinstance(self.negate, Set):
            raise UserError(f"negate: must be a set of roles such as {{'force'}}, got {self.negate!r}")
        for name in ("rate_hz", "r0_ohm"):
            if (value := getattr(self, name)) is not None and not 0 < number(name, value) < float("inf"):
                raise UserError(
                    f"{name}: must be a positive number, got {value!r}; leave it out where it is not known"
                )
        if self.repeat is not None and not isinstance(self.repeat, str):
            object.__setattr__(self, "repeat", whole("repeat", self.repeat, 0))
        for name in ("sort", "drop_bad"):
            object.__setattr__(self, name, flag(name, getattr(self, name)))
        if not isinstance(self.hints, Hints):
            raise UserError(f"hints: must be a testbench.Hints, got {self.hints!r}; tb.Hints(decimal=',')")

    def names(self) -> list[str]:
        """Columns that were given by name."""
        every = [*self.columns.values(), *self.time_of.values()]
        return [name for name in dict.fromkeys(every) if name != NOT_THERE and not name.strip().isdigit()]


def _check_by_role(name: str, given: object, or_none: bool) -> None:
    """What is said by role must be texts, of roles that there are."""
    if not isinstance(given, Mapping):
        raise UserError(f"{name}: must be a mapping of roles to texts such as {{'force': '3'}}, got {given!r}")
    roles = [role for role in ROLES if name != "time_of" or role != "time"]
    for role, text in given.items():
        if role not in roles:
            raise UserError(f"{name}: can be said of {', '.join(roles)}, got {role!r}")
        if not isinstance(text, str) and not (or_none and text is None):
            raise UserError(f"{name}: {role} must be a text such as {str(text)!r}, got {text!r}")
