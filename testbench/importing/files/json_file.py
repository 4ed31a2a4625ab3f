"""Tables in JSON: records in a list or one a line, rows, or columns by their names."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

from gcode.support.strict import MOST_BYTES, read_bytes
from testbench.importing.files.cells import Rows, check_size
from testbench.importing.files.encodings import encoding_of, known_encoding

_DEEPEST = 8  # levels of names above a table, and within a record


def tables_in(path: Path, encoding: str | None) -> dict[str, Rows] | None:
    """The tables by the names that lead to them, each below a row of names; None where the file is no JSON.

    Of records one a line, a line that is none becomes a row of nothing but its text.
    """
    if path.stat().st_size > MOST_BYTES:
        return None  # too large for the memory; flat records one a line are read as text, too
    raw = read_bytes(path, "table")
    text = raw.decode(known_encoding(encoding) if encoding else encoding_of(raw) or "utf-8", errors="replace")
    lines = text.splitlines()
    if len(lines) > 1 and isinstance(_parsed(next(filter(str.strip, lines), "")), dict):
        records = [_parsed(line) for line in lines]
        if 2 * sum(isinstance(one, dict) for one in records) > len(lines):
            return {"": _of_records(path, records, lines)}
    return dict(_found(path, _parsed(text))) or None


def _parsed(text: str) -> Any:
    try:
        return json.loads(text, parse_int=float, object_pairs_hook=_once)
    except (ValueError, RecursionError):
        return None


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len(found := dict(pairs)) < len(pairs):
        raise ValueError("a name that stands twice would lose a column")
    return found


def _found(path: Path, value: Any, name: str = "", depth: int = 0) -> list[tuple[str, Rows]]:
    """The tables in a value, with the names that lead to each."""
    if isinstance(value, list):
        if value and all(isinstance(one, dict) for one in value):
            return [(name, _of_records(path, value))]
        rows = [one for one in value if isinstance(one, list)]
        return [(name, [[""] * max(map(len, rows)), *rows])] if rows else []
    if not isinstance(value, dict) or depth > _DEEPEST:
        return []
    names, data = value.get("columns"), value.get("data")
    if isinstance(names, list) and isinstance(data, list) and all(isinstance(one, list) for one in data):
        return [(name, [[*map(str, names)], *data])]
    columns = {key: [*one.values()] if isinstance(one, dict) else one for key, one in value.items()}
    columns = {key: one for key, one in columns.items() if isinstance(one, list) and _are_plain(one)}
    length = max(map(len, columns.values()), default=0)
    columns = {key: one for key, one in columns.items() if len(one) == length}
    if length > 1 and len(columns) > 1:
        return [(name, [list(columns), *map(list, zip(*columns.values(), strict=True))])]
    inner = (_found(path, one, f"{name}.{key}".lstrip("."), depth + 1) for key, one in value.items())
    return [table for tables in inner for table in tables]


def _are_plain(values: Sequence[Any]) -> bool:
    return not any(isinstance(one, dict | list) for one in values)


def _of_records(path: Path, records: Sequence[Any], lines: Sequence[str] = ()) -> Rows:
    """Rows of what records hold, below all their names."""
    flat = [_flat(one) if isinstance(one, dict) else None for one in records]
    names = list(dict.fromkeys(name for one in flat if one for name in one))
    check_size(path, len(names) * len(flat))
    found = zip_longest(flat, lines, fillvalue="")
    return [names, *([one.get(name) for name in names] if isinstance(one, dict) else [line] for one, line in found)]


def _flat(record: Mapping[str, Any], name: str = "", depth: int = 0) -> dict[str, Any]:
    """A record without records in it: ``data.force`` for the force in its data."""
    flat: dict[str, Any] = {}
    for key, value in record.items():
        inner = f"{name}.{key}" if name else key
        if isinstance(value, dict) and depth < _DEEPEST:
            flat |= _flat(value, inner, depth + 1)
        else:
            flat[inner] = str(value) if isinstance(value, dict | list | bool) else value
    return flat
