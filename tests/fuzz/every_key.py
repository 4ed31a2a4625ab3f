"""Every key of a document in turn: missing, of another type, huge, tiny, no number, nested, or with a stranger.

The random attack of `tests.fuzz.targets` finds what nobody thought of; this one leaves no key out.
"""

from __future__ import annotations

import contextlib
import copy
import importlib
import io
import json
import warnings
import zlib
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, TypeVar

from tests.fuzz.grammars import MARK, places
from tests.fuzz.targets import no_hang

T = TypeVar("T")
STRANGER = "with a stranger"
STRANGE: dict[str, Any] = {
    "gone": None, "null": None, "true": True, "text": "text", "empty text": "", "long text": "a" * 600,
    "minus one": -1, "zero": 0, "two": 2, "half": 0.5, "huge": 1e300, "hugely negative": -1e300, "tiny": 5e-324,
    "whole and huge": 10**18, "empty list": [], "empty table": {}, "list": [1, "a", None], "table": {"a": {"b": 1}},
}  # fmt: skip
RAW = {
    "NaN": "NaN",
    "infinity": "1e999",
    "nested": "[" * 70 + "]" * 70,
    "nested deeply": '{"a":' * 3000 + "1" + "}" * 3000,
}


class Mutant(NamedTuple):
    """One changed document: its text, and what was changed in words."""

    text: str
    change: str


def mutants(document: Any, seal: Callable[[Any], str] = json.dumps, most: int = 1_000_000) -> Iterator[Mutant]:
    """Each key changed in each way, or at most so many of them.

    Of a list only the first and the last element are changed, which stand for the others.
    """
    known = [path for path in places(document)[1:] if _stands_for_others(document, path)]
    changes = [(path, way) for path in known for way in (*STRANGE, *RAW, STRANGER)]
    for path, way in chosen(changes, most, str):
        if way == STRANGER and not isinstance(_at(document, path), dict):
            continue
        changed = _changed(document, path, way)
        yield Mutant(_sealed(changed, seal).replace(MARK, RAW.get(way, ""), 1), f"{'.'.join(map(str, path))} {way}")


def chosen(found: Sequence[T], most: int, name: Callable[[T], str]) -> list[T]:
    """At most so many, by the checksums of their names: the same on every machine, whatever else was found there."""
    return sorted(found, key=lambda one: zlib.crc32(name(one).encode()))[:most]


def _stands_for_others(document: Any, path: tuple) -> bool:
    return all(
        not isinstance(key, int) or key in (0, len(_at(document, path[:depth])) - 1) for depth, key in enumerate(path)
    )


def _at(document: Any, path: tuple) -> Any:
    for key in path:
        document = document[key]
    return document


def _changed(document: Any, path: tuple, way: str) -> Any:
    changed = copy.deepcopy(document)
    holder, key = _at(changed, path[:-1]), path[-1]
    if way == STRANGER:
        holder[key]["stranger"] = 1
    elif way in RAW:
        holder[key] = json.loads(MARK)
    elif way == "gone":
        del holder[key]
    else:
        holder[key] = copy.deepcopy(STRANGE[way])
    return changed


def _sealed(document: Any, seal: Callable[[Any], str]) -> str:
    try:
        return seal(document)
    except (KeyError, TypeError, ValueError, AttributeError):
        return json.dumps(document)


def fault_of(command: str, allowed: Sequence[int] = (0, 1, 2)) -> str:
    """What is wrong with how a command answers; empty for an exit code that is `allowed`, without a traceback."""
    program, *words = command.split()
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), warnings.catch_warnings(), no_hang():
            warnings.simplefilter("ignore")  # numbers that overflow on their way to an error
            code = importlib.import_module(f"{program}.cli").main(words)
    except Exception as error:
        return f"{type(error).__name__}: {str(error)[:200]}"
    if code not in allowed:
        return f"exit code {code!r}: {said.getvalue()[-200:]}"
    sentences = said.getvalue().strip().splitlines()
    return "" if code < 2 or (sentences and "error: " in sentences[-1]) else "exit code 2 without a sentence"
