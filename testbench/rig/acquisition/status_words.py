"""How a recording shows itself: a line for people, or JSON lines for a program that watches."""

from __future__ import annotations

import contextlib
import json
import math
import re
import select
import sys
from dataclasses import asdict
from typing import Any, TextIO

from gcode.support.streams import redrawn
from testbench.rig.acquisition.recorder import Report, Status

LAST_WORD_MS = 2000  # how long the end of a recording waits to be shown


def as_text(status: Status) -> str:
    """One line: time, rate, losses, force, strain."""
    whole = f"/{status.duration_s:.0f}" if math.isfinite(status.duration_s) else ""
    parts = [f"{status.time_s:.1f}{whole} s", f"{status.samples} samples", f"{status.rate_hz:.1f} Hz"]
    parts.append(f"{status.lost} lost, {status.rejected} rejected")
    if status.unwritten:
        parts.append(f"{status.unwritten} NOT WRITTEN")
    if status.sync_failures:
        parts.append(f"the disk failed {status.sync_failures} times to keep what it took")
    if status.force_N is not None:
        parts.append(f"{status.force_N:.3f} N")
    if status.compensated is not None:
        parts.append(f"compensated {status.compensated:.3f} {status.compensated_unit}")
    if status.resistance_ohm is not None:
        parts.append(f"{status.resistance_ohm:.4g} ohm")
    parts.append(f"strain {status.strain:.3f}")
    return "  ".join(parts) + (f"  ! {status.message}" if status.message else "")


def as_dict(status: Status) -> dict[str, Any]:
    """JSON-ready form; an open duration is null."""
    data = asdict(status)
    return data | {"duration_s": status.duration_s if math.isfinite(status.duration_s) else None}


def terminal(label: str, stream: TextIO | None = None) -> Report:
    """Redraw one line on stderr, but for messages and the end, which stay whole; not redrawn where nobody watches."""
    out = stream or sys.stderr
    live, said = out.isatty(), ""

    def report(status: Status) -> None:
        nonlocal said
        ended = status.state != "recording"
        words = re.sub(r"\d", "", status.message)  # the same with other numbers, as of seconds that pass, is no news
        text, news = f"{label}: {as_text(status)}", bool(words) and words != said
        if live:
            _show(out, f"{redrawn('')}{text}\n" if ended or news else redrawn(text), ended)
        elif news:
            _show(out, f"{text}\n", ended)
        said = words

    return report


def json_lines() -> Report:
    """One JSON object a line on stdout, for a program that watches."""
    out = sys.stdout

    def report(status: Status) -> None:
        _show(out, json.dumps(as_dict(status)) + "\n", status.state != "recording")

    return report


def _show(out: TextIO, text: str, ended: bool) -> None:
    """Write what can be written at once: nobody who looks on may keep a recording waiting, or end it.

    A terminal may be stopped (Ctrl-S) or gone, a program may read no more, a log's disk may be full.
    """
    with contextlib.suppress(OSError):
        if _takes_more(out, LAST_WORD_MS if ended else 0):
            out.write(text)
            out.flush()


def _takes_more(out: TextIO, wait_ms: int) -> bool:
    """Whether a write would not wait; always for what is no file of the system."""
    try:
        number = out.fileno()
    except OSError:
        return True
    poll = select.poll()
    poll.register(number, select.POLLOUT)
    return bool(poll.poll(wait_ms))
