"""How a recording shows itself: a line for people, or JSON lines for a program that watches."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from dataclasses import asdict
from typing import Any, TextIO

from testbench.rig.recorder import Status

Report = Callable[[Status], None]


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
    """Redraw one line on stderr; where nobody watches, only messages and the end are printed."""
    out = stream or sys.stderr
    live, said = out.isatty(), ""

    def report(status: Status) -> None:
        nonlocal said
        ended = status.state != "recording"
        text = f"{label}: {as_text(status)}"
        if live:
            print(f"\r\x1b[K{text}", end="\n" if ended else "", file=out, flush=True)
        elif status.message and status.message != said:
            print(text, file=out, flush=True)
        said = status.message

    return report


def json_lines() -> Report:
    """One JSON object a line on stdout, for a program that watches."""

    def report(status: Status) -> None:
        print(json.dumps(as_dict(status)), flush=True)

    return report
