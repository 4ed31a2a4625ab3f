"""The modal state of a single-axis interpreter: what the words of a block change, and which blocks are refused.

Where readers differ (LinuxCNC's `rs274` was asked), a block is refused: what is checked must be what runs.
"""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field

import numpy as np

from gcode.mach4.program import MOST_HZ, Problem

MODES = ("G20 or G21", "G90 or G91", "G93 or G94")
PLACE = "a first place, X under G90,"
LARGEST = 1e9  # of any number in a program
NO_FEED = "no F is in force"
BESIDE = "stands beside G20 or G21 and is taken in the unit before; say it again below"
_INCH = 25.4
_OFFSETS = {54.0, 55.0, 56.0, 57.0, 58.0, 59.0}
_EXCLUSIVE = (
    *(("G", group) for group in ({0.0, 1.0, 4.0}, {20.0, 21.0}, {90.0, 91.0}, {93.0, 94.0}, {61.0, 64.0}, _OFFSETS)),
    *(("G", {code}) for code in (17.0, 40.0, 49.0, 80.0)),
    ("G", {4.0, 64.0}),  # a P may be the time of one or the tolerance of the other
    *(("M", group) for group in ({0.0, 1.0, 2.0, 30.0}, {5.0}, {9.0}, {48.0, 49.0})),
)
_ONCE = "NTSXFP"  # letters that a line may have once
_WIDEST_MM = 0.05  # by which a controller may leave the path; LinuxCNC leaves out strokes that are shorter
_IGNORED_G = {4.0, 17.0, 40.0, 49.0, 80.0}  # G4 and G80 have a say when the whole line is read
_IGNORED_M = {5.0, 9.0, 48.0, 49.0}
_STARTS_M = {3.0: "the spindle", 4.0: "the spindle", 7.0: "the coolant", 8.0: "the coolant"}
_WAITS_M = {0.0, 1.0}
_END_M = {2.0, 30.0}


class Rows:
    """Blocks as typed columns: a day's program has 1.7 million of them."""

    def __init__(self) -> None:
        self.line, self.steps, self.stop = array("q"), array("q"), array("b")
        self.x_mm, self.feed_mm_per_s, self.dwell_s = array("d"), array("d"), array("d")

    def __len__(self) -> int:
        return len(self.line)

    def add(self, line: int, x_mm: float, feed_mm_per_s: float, dwell_s: float, steps: int, stop: bool) -> None:
        """Append one block."""
        self.line.append(line)
        self.x_mm.append(x_mm)
        self.feed_mm_per_s.append(feed_mm_per_s)
        self.dwell_s.append(dwell_s)
        self.steps.append(steps)
        self.stop.append(stop)


@dataclass
class State:
    """The modal state of the interpreter and what it has read so far, up to line `number`."""

    number: int = 0
    motion: float | None = None
    feed: float | None = None
    inverse_time: bool = False
    incremental: bool = False
    exact_stop: bool = False
    unit: float = 1.0
    fed_unit: float | None = None  # the unit that the feed is in
    no_feed: str = NO_FEED
    x: float = 0.0
    offset: float | None = None
    said: set[str] = field(default_factory=set)
    unsaid: tuple[str, ...] | None = None  # None: nothing has moved yet
    begun: bool = False
    ended: bool = False
    rows: Rows = field(default_factory=Rows)
    problems: list[Problem] = field(default_factory=list)
    header: dict[str, str] = field(default_factory=dict)

    def refuse(self, reason: str) -> None:
        """Put down why this line is refused."""
        self.problems.append(Problem(self.number, reason))


def block(state: State, words: list[tuple[str, float]]) -> None:
    """Apply the words of a line; what is refused is put into the state's problems."""
    state.begun = True
    values: dict[str, float] = {}
    if clash := _clash(words):
        return state.refuse(clash)
    for letter, value in words:
        if problem := _word(state, values, letter, value):
            return state.refuse(problem)
    if ("G", 80.0) in words:
        state.motion = None  # beside G0 or G1 some readers heed it, whatever their order, and some do not
    if problem := _p(state, words, values):
        return state.refuse(problem)
    if values.get("F", 1.0) <= 0:
        state.refuse(f"feed F{values['F']:g} is not above 0; the axis would never arrive")
    _unit(state, words, values)
    state.feed = values.get("F", state.feed)
    if ("G", 4.0) in words:
        _dwell(state, values)
    elif "X" in values:
        x = values["X"] * state.unit
        move(state, state.x + x if state.incremental else x, "F" in values, 1)
    # An interpreter moves first and waits then, whatever their order in the line.
    if state.rows and (waits := [value for letter, value in words if letter == "M" and value in _WAITS_M]):
        state.refuse(f"M{waits[0]:g} waits for somebody in mid-program, for a time that the file does not say")
    return None


def _p(state: State, words: list[tuple[str, float]], values: dict[str, float]) -> str | None:
    """Why a P is refused that is no time of a dwell."""
    if "P" not in values or ("G", 4.0) in words:
        return None
    if ("G", 64.0) not in words:
        return "P stands without the G4 that it belongs to"
    if not 0 <= values["P"] * state.unit <= _WIDEST_MM:
        return f"G64 P{values['P']:g} lets the axis leave out strokes; P may be from 0 to {_WIDEST_MM:g} mm"
    return None


def _unit(state: State, words: list[tuple[str, float]], values: dict[str, float]) -> None:
    """A change of the unit, or its first mention, ends the feed in force.

    An interpreter takes F before G20 and G21, whatever their order in the line, and keeps the feed in mm or in inches
    per minute afterwards, as it likes: 25 times too fast. So F beside them counts for nothing: a move that relies on
    it is refused.
    """
    changed = any(letter == "G" and value in (20.0, 21.0) for letter, value in words)
    if changed and state.unit != state.fed_unit:
        state.fed_unit, state.feed = state.unit, None
        state.no_feed = f"F of line {state.number} {BESIDE}" if values.pop("F", None) else NO_FEED


def _clash(words: list[tuple[str, float]]) -> str | None:
    """Two words in a line that exclude each other: an interpreter takes either, or stops there, half-way."""
    for place, (letter, value) in enumerate(words):
        if letter in _ONCE and any(other == letter for other, _ in words[:place]):
            return f"{letter} is given twice"
        if letter in "NTS" and (problem := _number(place, letter, value)):
            return problem
    for letter, group in _EXCLUSIVE:
        found = sorted(value for other, value in words if other == letter and value in group)
        if len(found) > 1 and found[0] == found[-1]:
            return f"{letter}{found[0]:g} is given twice"
        if len(found) > 1:
            return " and ".join(f"{letter}{code:g}" for code in found) + " exclude each other in one line"
    return None


def _number(place: int, letter: str, value: float) -> str | None:
    """What is wrong with a number of a line, a tool or a spindle, which move nothing: an interpreter stops at it."""
    if letter == "N" and place:
        return f"N{value:g} stands behind another word; the number of a line comes first"
    if value < 0 or (letter != "S" and value != int(value)):
        return f"{letter}{value:g} must be a {'' if letter == 'S' else 'whole '}number, 0 or more"
    return None


def _word(state: State, values: dict[str, float], letter: str, value: float) -> str | None:
    """Apply one word; returns why it is refused, if it is."""
    if abs(value) > LARGEST:
        return f"{letter}{value:g} is beyond any machine"
    if letter == "G":
        return _g(state, value)
    if letter == "M":
        return _m(state, value)
    if letter in "XFP":
        values[letter] = value
        return None
    return None if letter in "NTS" else f"{letter} is not for a single-axis machine (only X moves)"


def _g(state: State, code: float) -> str | None:
    """Apply a G word; returns why it is refused, if it is."""
    if code in (0.0, 1.0):
        state.motion = code
    elif code in (20.0, 21.0):
        state.said.add("G20 or G21")
        state.unit = _INCH if code == 20.0 else 1.0
    elif code in (90.0, 91.0):
        state.said.add("G90 or G91")
        state.incremental = code == 91.0
    elif code in _OFFSETS:
        return _offset(state, code)
    elif code in (93.0, 94.0):
        state.said.add("G93 or G94")
        if state.inverse_time != (code == 93.0):
            state.inverse_time, state.feed = code == 93.0, None
    elif code in (61.0, 64.0):
        state.exact_stop = code == 61.0
        if state.exact_stop:
            return "G61 stops the axis at every block, which at least doubles the time; use G64"
    elif code not in _IGNORED_G:
        return f"G{code:g} is not understood on a single axis (G0, G1, G4 and modes are)"
    return None


def _offset(state: State, code: float) -> str | None:
    """A work offset moves the origin by an amount that only the controller knows."""
    if state.rows and code != state.offset:
        return f"G{code:g} moves the origin in mid-program, by an amount that the file does not say"
    state.offset = code
    return None


def _m(state: State, code: float) -> str | None:
    if code in _END_M:
        state.ended = True
    elif code in _STARTS_M:
        return f"M{code:g} starts {_STARTS_M[code]}, and nothing but the axis may move here; take it out"
    elif code not in _IGNORED_M | _WAITS_M:
        return f"M{code:g} is not understood"
    return None


def _dwell(state: State, values: dict[str, float]) -> None:
    if "X" in values:
        return state.refuse("G4 takes its time as P in seconds, not as X")
    if "P" not in values:
        return state.refuse("G4 needs P, the time in seconds")
    if not values["P"] > 0:
        return state.refuse(f"G4 P{values['P']:g} is no time above 0")
    state.rows.add(state.number, state.x, np.nan, values["P"], round(values["P"] * _rate(state)), state.exact_stop)
    return None


def _rate(state: State) -> float:
    try:
        rate_hz = float(state.header.get("rate_hz", "0"))
    except ValueError:
        return 0.0
    return rate_hz if 0 < rate_hz <= MOST_HZ else 0.0


def move(state: State, x: float, own_feed: bool, steps: int) -> None:
    """Append a move to `x` in mm, with the feed in force; `own_feed` says whether the line states one."""
    length = abs(x - state.x)
    if state.motion is None:
        state.refuse("a move before any G0 or G1")
    if state.motion == 0.0:
        feed = np.inf
    elif state.inverse_time:
        if not own_feed:
            state.refuse("under G93 every move needs an F of its own")
        feed = length * (state.feed or 0.0) / 60.0
    else:
        if state.feed is None:
            state.refuse(f"a move without a feed: {state.no_feed}")
        feed = (state.feed or 0.0) * state.unit / 60.0
    if length == 0 and state.rows:
        state.refuse(f"the move to X{x:g} has no length; some controllers stop at it")
    if state.unsaid is None:
        place = (PLACE,) if state.incremental else ()
        state.unsaid = (*(mode for mode in MODES if mode not in state.said), *place)
    state.x = x
    state.rows.add(state.number, x, feed, 0.0, steps, state.exact_stop)
