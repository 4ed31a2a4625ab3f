"""Whose code the studio may run: own effects are Python, and a workspace may come from somebody else.

What was agreed to is kept for the user of this machine, outside every workspace: a folder cannot vouch for itself.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from gcode.support.files import make_folder

FILE = "trusted-effects.txt"


def state_folder() -> Path:
    """Where this user's own state is kept (XDG base directories)."""
    given = os.environ.get("XDG_STATE_HOME")
    return (Path(given) if given else Path.home() / ".local" / "state") / "knitbench"


def is_trusted(path: Path) -> bool:
    """Whether the user agreed to run this very text of this very file."""
    try:
        return _mark(path) in (state_folder() / FILE).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeError):
        return False


def trust(path: Path) -> None:
    """Remember that the user agreed to run the file as it is now."""
    if is_trusted(path):
        return
    with (make_folder(state_folder()) / FILE).open("a", encoding="utf-8") as stream:
        stream.write(f"{_mark(path)}\n")


def _mark(path: Path) -> str:
    return f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.resolve()}"
