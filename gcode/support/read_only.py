"""What frozen results hold stays as it is, too: mappings and arrays that nobody changes in place."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn, TypeVar

from gcode.support.arrays import FloatArray

Key = TypeVar("Key")
Value = TypeVar("Value")


class ReadOnly(dict[Key, Value]):
    """A dict whose entries stay as they are.

    It is a dict, so that it is pickled, copied and written as JSON as one is, which a ``MappingProxyType``
    is not.
    """

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("what a result holds is not changed in place; change a copy: dict(...) makes one")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self),)


def read_only(mapping: Mapping[Key, Value]) -> ReadOnly[Key, Value]:
    """A copy that nobody changes, nor the mappings in it."""
    if isinstance(mapping, ReadOnly):
        return mapping
    entries: dict[Any, Any] = {
        key: read_only(value) if isinstance(value, dict) else value for key, value in mapping.items()
    }
    return ReadOnly(entries)


def keep_read_only(frozen: object, *names: str) -> None:
    """Make read-only the mappings that a frozen dataclass, just made, has under these names."""
    for name in names:
        object.__setattr__(frozen, name, read_only(getattr(frozen, name)))


def read_only_array(values: FloatArray) -> FloatArray:
    """A view of the same numbers that nobody changes them through."""
    view = values.view()
    view.flags.writeable = False
    return view


def free_copy(value: Any) -> Any:
    """Plain data, such as a result writes as JSON, as dicts and lists that whoever has them may change."""
    if isinstance(value, dict):
        return {key: free_copy(one) for key, one in value.items()}
    return [free_copy(one) for one in value] if isinstance(value, list) else value
