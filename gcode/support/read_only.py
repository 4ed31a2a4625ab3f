"""What frozen results hold stays as it is, too: mappings, sets and arrays that nobody changes in place."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import fields
from typing import Any, NoReturn, TypeVar

import numpy as np

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
        return read_only, (dict(self),)


class Unchanging:
    """A frozen dataclass of which nothing is changed in place, nor by whoever has what it was made of.

    So it is with a copy of it, and with what comes out of a pickle, which forgets that an array is not to be changed.
    """

    def __post_init__(self) -> None:
        for each in fields(self):  # type: ignore[arg-type]  # a dataclass is what inherits from this
            object.__setattr__(self, each.name, read_only(getattr(self, each.name)))

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update({each.name: state[each.name] for each in fields(self)})  # type: ignore[arg-type]
        Unchanging.__post_init__(self)


def read_only(value: Any) -> Any:
    """A copy that nobody changes of a mapping, a set, a tuple or an array, and of those in it; all else as it is."""
    if isinstance(value, np.ndarray):
        return read_only_array(value)
    if isinstance(value, Mapping) and not isinstance(value, ReadOnly):
        return ReadOnly({key: read_only(one) for key, one in value.items()})
    if type(value) is tuple:
        return tuple(map(read_only, value))
    return frozenset(value) if isinstance(value, Set) and not isinstance(value, Mapping) else value


def read_only_array(values: FloatArray) -> FloatArray:
    """The same numbers where nobody can change them; a copy where somebody could, were it through another array."""
    owner: Any = values
    while isinstance(owner, np.ndarray) and not owner.flags.writeable:
        owner = owner.base
    if owner is None:
        return values
    kept = np.array(values)
    kept.flags.writeable = False
    return kept


def free_copy(value: Any) -> Any:
    """Plain data, such as a result writes as JSON, as dicts and lists that whoever has them may change."""
    if isinstance(value, dict):
        return {key: free_copy(one) for key, one in value.items()}
    return [free_copy(one) for one in value] if isinstance(value, list) else value
