"""Results of a benchmark as JSON lines: a run that was stopped at any moment goes on from what is there."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

Row = dict[str, Any]


def read_rows(results: Path | None) -> list[Row]:
    """Rows of a results file; a line that a kill cut short is left out."""
    rows = []
    for line in results.read_text(encoding="utf-8").splitlines() if results is not None and results.exists() else ():
        try:
            rows.append(json.loads(line))
        except json.JSONDecodeError:
            continue
    return rows


def append(results: Path, row: Row) -> None:
    """Add a row on a line of its own, even after a line that a kill cut short."""
    with results.open("a+b") as stream:
        if stream.tell() > 0:
            stream.seek(-1, 2)
            cut = stream.read(1) != b"\n"
        else:
            cut = False
        stream.write(b"\n" * cut + json.dumps(row).encode() + b"\n")
