"""One strict loader for every file that we read: plain files of a bounded size, of a bounded depth, finite, typed.

A file may be damaged, hostile, or a pipe that never ends. What leaves this module is either bytes of a bounded size,
plain data whose depth and numbers are bounded, or an instance of a pydantic model; anything else is a `UserError`
that names the file. No other module parses JSON or TOML.
"""

from __future__ import annotations

import json
import math
import os
import re
import stat
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError

from gcode.support.errors import UserError, first_problem
from gcode.support.kinds import only_by_name, path_of

MOST_BYTES = 256 << 20
MOST_TOML_BYTES = 1 << 20
DEEPEST = 64
LARGEST_WHOLE = 1 << 64
MOST_VALUES = 5_000_000  # 3 bytes of JSON, "[],", take 80 of memory
_BLOCK = 1 << 20
_STEERS = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]")  # a terminal, or no text at all

Loaded = TypeVar("Loaded")


class StrictModel(BaseModel):
    """What a file may say: nothing unknown, nothing infinite, and nothing changed once it is loaded."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class NamedModel(BaseModel):
    """What people make in Python, field by field: what is wrong with one is told in a sentence."""

    def __init__(self, *unnamed: Any, **fields: Any) -> None:
        """Raise `UserError` where a field is unknown, unnamed or missing, or has a value that it cannot have."""
        only_by_name(type(self), "fields", unnamed)
        name = self.model_config.get("title") or type(self).__name__
        try:
            super().__init__(**fields)
        except ValidationError as error:
            raise UserError(f"{name}: {first_problem(error)}") from None
        for where, came in _made_up("", fields, self):
            raise UserError(f"{name}: {where}: must be a number, got {came!r}")

    # As pydantic marks its own: what is validated as a part of something else is not made by a call of `__init__`, so
    # that the error says where in the whole it is.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]


def _made_up(where: str, given: Any, taken: Any) -> Iterator[tuple[str, Any]]:
    """Where a number was made of a text, or of a yes or no, as pydantic does; and that text."""
    if isinstance(given, dict):
        inside = taken if isinstance(taken, dict) else getattr(taken, "__dict__", {})
        for name, one in given.items():
            yield from _made_up(f"{where}.{name}".lstrip("."), one, inside.get(name))
    elif isinstance(given, list | tuple) and isinstance(taken, list | tuple):
        for number, (one, other) in enumerate(zip(given, taken, strict=False)):
            yield from _made_up(f"{where}.{number}", one, other)
    elif isinstance(given, str | bool) and isinstance(taken, int | float) and type(given) is not type(taken):
        yield where, given


class ExtraIgnored(StrictModel):
    """As `StrictModel`, of a file that may say more than we ask of it; what else it says goes no further."""

    model_config = ConfigDict(extra="ignore")


def read_bytes(path: str | Path, what: str = "file", at_most: int = MOST_BYTES) -> bytes:
    """The bytes of a plain file.

    Parameters
    ----------
    path : path
    what : str
        For messages: "model", "campaign manifest".
    at_most : int
        Larger files are refused.

    Raises
    ------
    UserError
        If it is missing, cannot be read, is larger, or is a folder, a pipe or a device: those may never end.
    """
    return b"".join(blocks_of(path, what, at_most))


def blocks_of(path: str | Path, what: str = "file", at_most: int | None = None) -> Iterator[bytes]:
    """The bytes of a plain file in blocks, as many as it says that it has; see `read_bytes`.

    What has no size is empty, or is made up while it is read, as the kernel's log is: a read of that never ends.
    """
    with os.fdopen(open_plain(path, what), "rb", buffering=0) as stream:
        left = os.fstat(stream.fileno()).st_size
        if at_most is not None and left > at_most:
            raise UserError(f"{path}: not a {what}: it is larger than {_in_words(at_most)}")
        try:
            while left > 0 and (block := stream.read(min(left, _BLOCK))):
                left -= len(block)
                yield block
        except OSError as error:
            raise UserError(f"{path}: cannot read this {what}: {error.strerror or error}") from error


def open_plain(path: str | Path, what: str = "file") -> int:
    """A handle on a plain file, open for reading; see `read_bytes`. Opening a pipe would wait for ever."""
    path = path_of(path, what)
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except (OSError, ValueError) as error:
        # ValueError: a name with a zero byte in it.
        raise UserError(f"{path}: cannot read this {what}: {getattr(error, 'strerror', None) or error}") from error
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise UserError(f"{path}: not a {what}: it is a folder, a pipe or a device; give a plain file")
    return handle


def check_plain(path: str | Path, what: str = "file", at_most: int = MOST_BYTES, may_be_empty: bool = False) -> int:
    """The size of a plain file that others will read; see `read_bytes` for what is refused.

    An empty file is refused unless it `may_be_empty`: a killed recorder has not always written its first line.
    """
    handle = open_plain(path, what)
    try:
        size = os.fstat(handle).st_size
    finally:
        os.close(handle)
    if size > at_most:
        raise UserError(f"{path}: not a {what}: it is larger than {_in_words(at_most)}")
    if size == 0 and not may_be_empty:
        raise UserError(f"{path}: not a {what}: the file is empty")
    return size


def read_text(path: str | Path, what: str = "file", at_most: int = MOST_BYTES) -> str:
    """The text of a plain file in UTF-8; see `read_bytes`."""
    try:
        return read_bytes(path, what, at_most).decode("utf-8")
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: not a {what}: byte {error.start} is not text (UTF-8)") from error


def read_json(path: str | Path, what: str = "file", at_most: int = MOST_BYTES) -> Any:
    """Plain data from JSON: finite numbers, no name twice, at most 64 levels deep.

    Raises
    ------
    UserError
        That names the file, and the line where there is one.
    """
    return json_of(read_text(path, what, at_most), what, path)


def json_of(text: str, what: str = "text", source: str | Path = "") -> Any:
    """Plain data from JSON text; see `read_json`."""

    def parse() -> Any:
        if text.count(",") + text.count("[") + text.count("{") > MOST_VALUES:
            raise ValueError(f"it holds more than {MOST_VALUES} values")
        return json.loads(text, object_pairs_hook=_once, parse_constant=_no_constant)

    return _parsed(parse, what, source)


def read_toml(path: str | Path, what: str = "spec") -> dict[str, Any]:
    """Plain data from TOML; see `read_json`."""
    text = read_text(path, what, MOST_TOML_BYTES)

    def parse() -> dict[str, Any]:
        # The parser takes the square of the length of a dotted key, in time and in memory.
        if max(part.count(".") for part in re.split(r"[=,{}\[\]\n]", text)) > DEEPEST:
            raise ValueError(f"it is nested more than {DEEPEST} levels deep")
        return tomllib.loads(text)

    # TOML has infinity and NaN; the models of our specs refuse them by the name of the entry.
    return _parsed(parse, what, path, finite=False)


def load(path: str | Path, kind: type[Loaded], what: str = "file", at_most: int = MOST_BYTES) -> Loaded:
    """A file as an instance of the model `kind`; ``.toml`` is read as TOML, anything else as JSON.

    Raises
    ------
    UserError
        That names the file and the entry, what is allowed and what came.
    """
    data = read_toml(path, what) if Path(path).suffix == ".toml" else read_json(path, what, at_most)
    return validated(data, kind, path, what)


def validated(data: Any, kind: type[Loaded], source: str | Path, what: str = "file") -> Loaded:
    """Plain data as an instance of the model `kind`, or of any type that pydantic knows; see `load`."""
    try:
        return TypeAdapter(kind).validate_python(data)
    except UserError:
        raise
    except (ValidationError, RecursionError, OverflowError) as error:
        raise UserError(f"{source}: not a usable {what}: {first_problem(error)}") from None


def check_bounds(data: Any, finite: bool = True) -> None:
    """Refuse what is too deep, numbers that are infinite, no number, or beyond 64 bits, and text that is none.

    Raises
    ------
    ValueError
    """
    level, depth = [data], 0
    while level:
        if depth > DEEPEST:
            raise ValueError(f"it is nested more than {DEEPEST} levels deep")
        below: list[Any] = []
        for value in level:
            if isinstance(value, dict):
                below.extend(value)
                below.extend(value.values())
            elif isinstance(value, list):
                below.extend(value)
            elif finite and isinstance(value, float) and not math.isfinite(value):
                raise ValueError("it holds a number that is not finite")
            elif isinstance(value, int) and abs(value) >= LARGEST_WHOLE:
                raise ValueError("it holds a whole number of more than 64 bits")
            elif isinstance(value, str) and not value.isprintable() and _STEERS.search(value):
                raise ValueError("it holds a control character, or half of a character")
        level, depth = below, depth + 1


def _parsed(parse: Callable[[], Any], what: str, source: str | Path, finite: bool = True) -> Any:
    place = f"{source}: " if source else ""
    try:
        data = parse()
        check_bounds(data, finite)
    except json.JSONDecodeError as error:
        raise UserError(f"{place}not a {what}: line {error.lineno} is not valid JSON ({error.msg})") from error
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{place}not valid TOML: {error}") from error
    except RecursionError:
        raise UserError(f"{place}not a {what}: it is nested more than {DEEPEST} levels deep") from None
    except ValueError as error:
        # Python refuses whole numbers of more than 4300 digits by a ValueError of its own.
        reason = "it holds a number of thousands of digits" if "integer string" in str(error) else str(error)
        raise UserError(f"{place}not a {what}: {reason}") from None
    return data


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    data = dict(pairs)
    if len(data) < len(pairs):
        seen: set[str] = set()
        twice = next(name for name, _ in pairs if name in seen or seen.add(name))  # type: ignore[func-returns-value]
        raise ValueError(f"it says {twice[:60]!r} twice")
    return data


def _no_constant(text: str) -> float:
    raise ValueError(f"it holds {text}, which is no number in JSON")


def _in_words(size: int) -> str:
    return f"{size >> 20} MB" if size >= 1 << 20 else f"{size} bytes"
