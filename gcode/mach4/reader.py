"""Reads our own Mach4 programs and plain RS274/NGC programs that move one axis.

`parse_program` never stops at the first fault: it collects every line it refuses, so that `gcode check` can
list them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from gcode.mach4.interpreter import State, block, move
from gcode.mach4.program import Problem, Program
from gcode.support import strict
from gcode.support.errors import UserError

MAX_LINE = 255
LONGEST_COMMENT = 200  # characters; a controller may cut off or refuse a longer one
MOST_BYTES = 512 << 20
MOST_LINES = 25_000_000  # the longest program that is written here has 20 million
MOST_PROBLEMS = 1000  # then it is read no further
_OWN_MOVE = re.compile(r"G1 X(-?\d{1,6}\.\d{1,9}) F(\d{1,9}\.\d{1,9})(?: \(STEPS (\d{1,7})\))?", re.ASCII)
_COMMENT = re.compile(r"\(([^()]*)\)")
_THERE = "\x01"  # stands where a comment stood: between words, but not in one, where an interpreter stops
_WORD = re.compile(rf"[\s{_THERE}]*([A-Z])\s*([+-]?(?:\d+\.?\d*|\.\d+))(?![\d.])", re.ASCII)
_KEY = re.compile(r"([A-Z0-9_.]+): (.*)")
_ACTED_ON = re.compile(r"(?:LOG|LOGOPEN|LOGAPPEND|PY),|LOGCLOSE|PROBEOPEN|PROBECLOSE")  # LinuxCNC; MSG only shows
_WHOLE_DWELL = re.compile(r"(?=.*G\s*0*4(?:\.0*)?(?![\d.])).*P\s*(\d{3,})(?![\d.])", re.ASCII)
_PRINTED = re.compile(r"[\t -~]*")


def read_text(path: str | Path) -> str:
    """The text of a program file; a `UserError` names a file that cannot be read or is no text."""
    return strict.read_text(path, "program", MOST_BYTES)


def load_program(path: str | Path) -> Program:
    """Read a file that must be a sound program; see `read_program`."""
    return read_program(read_text(path), str(path))


def read_program(text: str, source: str = "program") -> Program:
    """Read a program that must be sound.

    Raises
    ------
    UserError
        With `source`, line number and reason of the first fault.
    """
    program = parse_program(text)
    if program.problems:
        more = f" (and {len(program.problems) - 1} more; see gcode check)" if len(program.problems) > 1 else ""
        raise UserError(f"{source}: {program.problems[0]}{more}")
    return program


def parse_program(text: str) -> Program:
    """Read any program; what cannot be understood is listed in ``problems`` and skipped."""
    state = State()
    for state.number, line in enumerate(_lines(text), start=1):
        if state.ended:
            if _COMMENT.sub("", line).strip() not in ("", "%"):
                state.refuse("follows the program's end (M30 or M2) and would never run")
                break
            continue
        match = _OWN_MOVE.fullmatch(line)
        if match and not state.incremental and state.unit == 1.0 and float(match[2]) > 0:
            state.motion, state.feed = 1.0, float(match[2])
            move(state, float(match[1]), True, int(match[3] or 1))
        else:
            _line(state, line)
        if len(state.problems) >= MOST_PROBLEMS or state.number >= MOST_LINES:
            state.refuse("the program was read no further")
            return _program(state)
    if not state.ended:
        state.problems.append(Problem(max(text.count("\n"), 1), "the program does not end with M30 or M2"))
    return _program(state)


def _lines(text: str) -> Iterator[str]:
    """Lines without their ends; a list of them, or io.StringIO, would hold the text four times more."""
    at = 0
    while at < len(text):
        end = text.find("\n", at)
        end = len(text) if end < 0 else end
        yield text[at : end - 1] if text.startswith("\r", end - 1) and end > at else text[at:end]
        at = end + 1


def _program(state: State) -> Program:
    rows = state.rows
    return Program(
        line=np.array(rows.line),
        position_mm=np.array(rows.x_mm),
        feed_mm_per_s=np.array(rows.feed_mm_per_s),
        dwell_s=np.array(rows.dwell_s),
        steps=np.array(rows.steps),
        exact_stop=np.array(rows.stop, dtype=bool),
        header=state.header,
        problems=tuple(state.problems),
        unsaid=state.unsaid or (),
    )


def _line(state: State, line: str) -> None:
    if len(line) > MAX_LINE:
        return state.refuse(f"the line is {len(line)} characters long; controllers take at most {MAX_LINE}")
    _comments(state, line)
    code = _COMMENT.sub(_THERE, line).split(";")[0].strip(f" \t{_THERE}").upper()
    if not _PRINTED.fullmatch(line):
        # A lone carriage return ends a line, and with it a comment, on some controllers.
        return state.refuse("the line holds characters that are not ASCII, or not printed; controllers choke on them")
    if match := _WHOLE_DWELL.search(code):
        state.refuse(f"G4 P{match[1]} looks like milliseconds; P is in seconds (write P{match[1]}.0 if it is meant)")
    if "(" in code or ")" in code:
        return state.refuse("a comment is not closed, or comments are nested")
    if code == "%":
        return _percent(state)
    if code:
        words = _words(code)
        return state.refuse(words) if isinstance(words, str) else block(state, words)
    return None


def _comments(state: State, line: str) -> None:
    """Take the header's values from the comments of a line."""
    comments = _COMMENT.findall(line)
    for comment in comments:
        if len(comment) > LONGEST_COMMENT:
            state.refuse(f"the comment is {len(comment)} characters long; at most {LONGEST_COMMENT} are safe")
        if not state.rows and (match := _KEY.fullmatch(comment.strip().upper())):
            state.header[match[1].lower()] = match[2].lower()
    for comment in (*comments, *line.split(";")[1:]):
        if match := _ACTED_ON.match("".join(comment.split()).upper()):
            state.refuse(f"the comment {match[0].strip(',')} writes files or runs code on some controllers")


def _percent(state: State) -> None:
    """A first one may mark the program's begin; any other is its end."""
    if state.begun or state.rows:
        state.refuse("% ends the program here: what follows would never run")
    state.begun = True


def _words(code: str) -> list[tuple[str, float]] | str:
    """The words of a line, or why it cannot be read."""
    words, at = [], 0
    while at < len(code):
        match = _WORD.match(code, at)
        if not match:
            rest = code[at:].replace(_THERE, "()").strip()
            if "NAN" in code or "INF" in code:
                return f"{rest[:20]!r} is not a number"
            return f"cannot read {rest[:20]!r} (exponents, expressions and variables are not plain G-code)"
        words.append((match[1], float(match[2])))
        at = match.end()
        if re.match(r"E[+-]?\d", code[at:]):
            return f"{code[match.start() : at + 4].strip(f' {_THERE}')!r} has an exponent; controllers refuse it"
    return words
