"""Reads our own Mach4 programs and plain RS274/NGC programs that move one axis.

`parse_program` never stops at the first fault: it collects every line it refuses, so that `gcode check` can
list them.
"""

from __future__ import annotations

import io
import re
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gcode.mach4.program import Problem, Program
from gcode.support import strict
from gcode.support.errors import UserError

MAX_LINE = 255
MAX_COMMENT = 200
MAX_RATE_HZ = 10_000.0
MODES = ("G20 or G21", "G90 or G91", "G93 or G94")
MOST_BYTES = 1 << 30
_OWN_MOVE = re.compile(r"G1 X(-?\d{1,6}\.\d{1,9}) F(\d{1,9}\.\d{1,9})(?: \(STEPS (\d{1,7})\))?")
_COMMENT = re.compile(r"\(([^()]*)\)")
_WORD = re.compile(r"\s*([A-Z])\s*([+-]?(?:\d+\.?\d*|\.\d+))(?![\d.])")
_KEY = re.compile(r"([A-Z0-9_.]+): (.*)")
_INCH = 25.4
_MODAL_GROUPS = ({0.0, 1.0, 4.0}, {20.0, 21.0}, {90.0, 91.0}, {93.0, 94.0}, {61.0, 64.0})
_WHOLE_DWELL = re.compile(r"G0*4(?![\d.]).*P\s*(\d{3,})(?![\d.])")
_OFFSETS = {54.0, 55.0, 56.0, 57.0, 58.0, 59.0}
_IGNORED_G = {17.0, 40.0, 49.0, 80.0}
LARGEST = 1e9  # of any number in a program
_IGNORED_M = {0.0, 1.0, 3.0, 4.0, 5.0, 7.0, 8.0, 9.0, 48.0, 49.0}
_END_M = {2.0, 30.0}


class _Rows:
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
class _State:
    """The modal state of the interpreter and what it has read so far."""

    motion: float | None = None
    feed: float | None = None
    inverse_time: bool = False
    incremental: bool = False
    exact_stop: bool = False
    unit: float = 1.0
    x: float = 0.0
    offset: float | None = None
    said: set[str] = field(default_factory=set)
    unsaid: tuple[str, ...] = ()
    ended: bool = False
    rows: _Rows = field(default_factory=_Rows)
    problems: list[Problem] = field(default_factory=list)
    header: dict[str, str] = field(default_factory=dict)


def read_text(path: str | Path) -> str:
    """The text of a program file; a `UserError` names a file that cannot be read or is no text."""
    return strict.read_text(path, "program", MOST_BYTES)


def read_program(text: str) -> Program:
    """Read a program that must be sound.

    Raises
    ------
    UserError
        With line number and reason of the first fault.
    """
    program = parse_program(text)
    if program.problems:
        more = f" (and {len(program.problems) - 1} more; see gcode check)" if len(program.problems) > 1 else ""
        raise UserError(f"program: {program.problems[0]}{more}")
    return program


def parse_program(text: str) -> Program:
    """Read any program; what cannot be understood is listed in ``problems`` and skipped."""
    state = _State()
    for number, line in enumerate(io.StringIO(text), start=1):
        line = line.rstrip("\r\n")
        if state.ended:
            if _COMMENT.sub("", line).strip() not in ("", "%"):
                state.problems.append(Problem(number, "follows the program's end (M30 or M2) and would never run"))
                break
            continue
        match = _OWN_MOVE.fullmatch(line)
        if match and not state.incremental and state.unit == 1.0 and float(match[2]) > 0:
            state.motion, state.feed = 1.0, float(match[2])
            _move(state, number, float(match[1]), True, int(match[3] or 1))
        else:
            _line(state, number, line)
    if not state.ended:
        state.problems.append(Problem(max(text.count("\n"), 1), "the program does not end with M30 or M2"))
    return _program(state)


def _program(state: _State) -> Program:
    rows = state.rows
    return Program(
        line=np.array(rows.line),
        position_mm=np.array(rows.x_mm),
        feed_mm_per_s=np.array(rows.feed_mm_per_s),
        dwell_s=np.array(rows.dwell_s),
        steps=np.array(rows.steps),
        exact_stop=np.array(rows.stop, dtype=bool),
        header=state.header,
        problems=state.problems,
        unsaid=state.unsaid,
    )


def _line(state: _State, number: int, line: str) -> None:
    refuse = _refuser(state, number)
    if len(line) > MAX_LINE:
        return refuse(f"the line is {len(line)} characters long; controllers take at most {MAX_LINE}")
    for comment in _COMMENT.findall(line):
        if len(comment) > MAX_COMMENT:
            refuse(f"the comment is {len(comment)} characters long; at most {MAX_COMMENT} are safe")
        if not state.rows and (match := _KEY.fullmatch(comment.strip())):
            state.header[match[1].lower()] = match[2].lower()
    code = _COMMENT.sub(" ", line).split(";")[0].strip().upper()
    if not line.isascii():
        return refuse("the line holds characters that are not ASCII; controllers choke on them")
    if match := _WHOLE_DWELL.search(code):
        refuse(f"G4 P{match[1]} looks like milliseconds; P is in seconds (write P{match[1]}.0 if it is meant)")
    if "(" in code or ")" in code:
        return refuse("a comment is not closed, or comments are nested")
    if code in ("", "%"):
        return None
    words = _words(code)
    if isinstance(words, str):
        return refuse(words)
    return _block(state, number, words)


def _refuser(state: _State, number: int) -> Callable[[str], None]:
    return lambda reason: state.problems.append(Problem(number, reason))


def _words(code: str) -> list[tuple[str, float]] | str:
    """The words of a line, or why it cannot be read."""
    words, at = [], 0
    while at < len(code):
        match = _WORD.match(code, at)
        if not match:
            rest = code[at:].strip()
            if "NAN" in code or "INF" in code:
                return f"{rest[:20]!r} is not a number"
            return f"cannot read {rest[:20]!r} (exponents, expressions and variables are not plain G-code)"
        words.append((match[1], float(match[2])))
        at = match.end()
        if re.match(r"E[+-]?\d", code[at:]):
            return f"{code[match.start() : at + 4].strip()!r} has an exponent; controllers refuse it"
    return words


def _block(state: _State, number: int, words: list[tuple[str, float]]) -> None:
    refuse = _refuser(state, number)
    values: dict[str, float] = {}
    if clash := _clash(words):
        return refuse(clash)
    for letter, value in words:
        if problem := _word(state, values, letter, value):
            return refuse(problem)
    if "F" in values:
        state.feed = values["F"]
        if values["F"] <= 0:
            refuse(f"feed F{values['F']:g} is not above 0; the axis would never arrive")
    if ("G", 4.0) in words:
        return _dwell(state, number, values)
    if "X" in values:
        x = values["X"] * state.unit
        _move(state, number, state.x + x if state.incremental else x, "F" in values, 1)
    return None


def _clash(words: list[tuple[str, float]]) -> str | None:
    """Two words of one modal group in a line: an interpreter takes either, or stops."""
    codes = {value for letter, value in words if letter == "G"}
    for group in _MODAL_GROUPS:
        if len(codes & group) > 1:
            return " and ".join(f"G{code:g}" for code in sorted(codes & group)) + " exclude each other in one line"
    return None


def _word(state: _State, values: dict[str, float], letter: str, value: float) -> str | None:
    """Apply one word; returns why it is refused, if it is."""
    if abs(value) > LARGEST:
        return f"{letter}{value:g} is beyond any machine"
    if letter == "G":
        return _g(state, value)
    if letter == "M":
        return _m(state, value)
    if letter in "XFP":
        problem = f"{letter} is given twice" if letter in values else None
        values[letter] = value
        return problem
    return None if letter in "NTS" else f"{letter} is not for a single-axis machine (only X moves)"


def _g(state: _State, code: float) -> str | None:
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
    elif code not in _IGNORED_G and code != 4.0:
        return f"G{code:g} is not understood on a single axis (G0, G1, G4 and modes are)"
    return None


def _offset(state: _State, code: float) -> str | None:
    """A work offset moves the origin by an amount that only the controller knows."""
    if state.rows and code != state.offset:
        return f"G{code:g} moves the origin in mid-program, by an amount that the file does not say"
    state.offset = code
    return None


def _m(state: _State, code: float) -> str | None:
    if code in _END_M:
        state.ended = True
    elif code not in _IGNORED_M:
        return f"M{code:g} is not understood"
    return None


def _dwell(state: _State, number: int, values: dict[str, float]) -> None:
    refuse = _refuser(state, number)
    if "X" in values:
        return refuse("G4 takes its time as P in seconds, not as X")
    if "P" not in values:
        return refuse("G4 needs P, the time in seconds")
    if not values["P"] > 0:
        return refuse(f"G4 P{values['P']:g} is no time above 0")
    state.rows.add(number, state.x, np.nan, values["P"], round(values["P"] * _rate(state)), state.exact_stop)
    return None


def _rate(state: _State) -> float:
    try:
        rate_hz = float(state.header.get("rate_hz", "0"))
    except ValueError:
        return 0.0
    return rate_hz if 0 < rate_hz <= MAX_RATE_HZ else 0.0


def _move(state: _State, number: int, x: float, own_feed: bool, steps: int) -> None:
    refuse = _refuser(state, number)
    length = abs(x - state.x)
    if state.motion is None:
        refuse("a move before any G0 or G1")
    if state.motion == 0.0:
        feed = np.inf
    elif state.inverse_time:
        if not own_feed:
            refuse("under G93 every move needs an F of its own")
        feed = length * (state.feed or 0.0) / 60.0
    else:
        if state.feed is None:
            refuse("a move without a feed: no F is in force")
        feed = (state.feed or 0.0) * state.unit / 60.0
    if length == 0 and state.rows:
        refuse(f"the move to X{x:g} has no length; some controllers stop at it")
    if not state.rows:
        state.unsaid = tuple(mode for mode in MODES if mode not in state.said)
    state.x = x
    state.rows.add(number, x, feed, 0.0, steps, state.exact_stop)
