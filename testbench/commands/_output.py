"""How commands say what was found: as text, as JSON, and what a reader should know of it on stderr."""

from __future__ import annotations

import json
import sys
from typing import Any


def show(found: Any, place: str | None) -> None:
    """Write the JSON of a result where a place is named, then print it as text; ``-`` prints the JSON instead."""
    from gcode.support.files import write_json

    if place and place != "-":
        write_json(place, found.to_dict())
    print(json.dumps(found.to_dict(), indent=2) if place == "-" else found)


def show_notes(found: Any) -> None:
    """Print what a reader should know of a result on stderr."""
    from gcode.support.console import printable

    for note in found.notes:
        print(printable(f"note: {note}"), file=sys.stderr)
