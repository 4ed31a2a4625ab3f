"""The seal of a program: a header comment with the SHA-256 of everything else in the file.

It finds a line that was lost, swapped or changed on the way to the machine. Line ends do not count: Mach4 runs on
Windows, and a file may come there with others. It is no signature; `gcode.programs.made_again` makes the program
again from its recipe.
"""

from __future__ import annotations

import hashlib
import re

_SEAL = re.compile(r"^\(SHA256: ([0-9A-F]{64})\)$", re.MULTILINE)


def sealed(text: str) -> str:
    """`text` with its seal after the last line of the header."""
    lines = text.split("\n")
    end = next((number for number, line in enumerate(lines) if not line.startswith("(")), len(lines))
    return "\n".join([*lines[:end], f"(SHA256: {_digest(text)})", *lines[end:]])


def seal_problem(text: str) -> str:
    """What the seal says of a program: empty if it holds, else in words."""
    text = text.replace("\r\n", "\n")
    found = _SEAL.findall(text)
    if not found:
        return "its header has no SHA256: an older knitbench made it, or the line was taken out"
    unsealed = "\n".join(line for line in text.split("\n") if not _SEAL.fullmatch(line))
    if len(found) > 1 or _digest(unsealed) != found[0]:
        return "was changed since it was written: its lines do not agree with the SHA256 in its header"
    return ""


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest().upper()
