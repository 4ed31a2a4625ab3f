"""Header comments: short, upper-case, parenthesised, and enough to make the file again.

Nested values become dotted keys, ``(SPEC.PIECES.0.OCTAVES: 2)``. Mach4 comments are upper case by custom, so keys and
text values are lower case in the data and survive the change of case.

The last comment is the seal: the SHA-256 of everything else in the file. It finds a line that was lost, swapped or
changed on the way to the machine. Line ends do not count: Mach4 runs on Windows, and a file may get others there. It
is no signature; `gcode.programs.made_again` makes the program again from its recipe.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from typing import Any

from gcode.support.errors import UserError

WRITTEN_COMMENT = 96  # interpreters refuse over-long comments; long lists are split over several
_SEAL = re.compile(r"^\(SHA256: ([0-9A-F]{64})\)$", re.MULTILINE)


def header_lines(about: dict[str, Any]) -> list[str]:
    """The header's lines, a comment for each value."""
    lines = []
    for key, value in flatten(about).items():
        text = f"({key}: {value})".upper()
        if len(text) > WRITTEN_COMMENT or text.count("(") != 1 or text.count(")") != 1:
            raise UserError(f"header: {key} cannot be written as a comment of at most {WRITTEN_COMMENT} characters")
        lines.append(text)
    return lines


def flatten(data: Any, prefix: str = "") -> dict[str, str]:
    """Nested dicts and lists as dotted keys with JSON values; text without quotes."""
    if isinstance(data, dict):
        items = list(data.items())
    elif isinstance(data, list | tuple):
        items = [(str(index), value) for index, value in enumerate(data)]
    else:
        return {prefix: data if isinstance(data, str) else json.dumps(data, allow_nan=False)}
    flat: dict[str, str] = {}
    for key, value in items:
        flat.update(flatten(value, f"{prefix}.{key}" if prefix else str(key)))
    return flat


def unflatten(flat: Mapping[str, str], prefix: str) -> Any:
    """What `flatten` made of the value under `prefix`, nested again.

    Its ends stay text: ``51`` may be a number or a name, which the model that they are validated with knows.
    """
    tree: dict[str, Any] = {}
    for key, text in flat.items():
        if not key.startswith(prefix + "."):
            continue
        *parents, leaf = key[len(prefix) + 1 :].split(".")
        branch = tree
        for parent in parents:
            branch = branch.setdefault(parent, {})
            if not isinstance(branch, dict):
                raise UserError(f"header: {key} stands below a value; only our own files can be made again")
        branch[leaf] = text
    return _listed(tree)


def _listed(tree: Any) -> Any:
    if not isinstance(tree, dict):
        return tree
    values = {key: _listed(value) for key, value in tree.items()}
    if values and all(key.isascii() and key.isdigit() for key in values):
        return [values[key] for key in sorted(values, key=int)]
    return values


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
