"""What a Python call was given, held against the kind that is wanted: one sentence where it is another."""

from __future__ import annotations

import os
from collections.abc import Sequence
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from gcode.support.errors import UserError

if TYPE_CHECKING:
    from pydantic import BaseModel

Wanted = TypeVar("Wanted")


def path_of(path: str | Path, what: str = "file") -> Path:
    """What a person gave as the path of a `what`; anything else is a `UserError`, and so is an empty text.

    Python takes that for the folder one is in; but it comes from a variable that was never set.
    """
    if not isinstance(path, str | os.PathLike):
        raise UserError(f"got {type(path).__name__}, not the path of a {what}")
    if not os.fspath(path):
        raise UserError(f"got an empty text, not the path of a {what}; name it ('.' is the folder you are in)")
    return Path(path)


def is_number(value: Any, kind: type = Real) -> bool:
    """Whether it is a number of the kind (`Real`, `Integral`), of Python or of numpy; True and False are none."""
    return isinstance(value, kind) and not isinstance(value, bool)


def number(name: str, value: Any, least: float | None = None) -> float:
    """A number that was given, of Python or of numpy.

    Parameters
    ----------
    name : str
        Of the argument, with its unit, for the message.
    value : float
    least : float, optional
        The smallest that is allowed; None: any, and what is no number (NaN), too.

    Raises
    ------
    UserError
        If it is none, or less than `least`.
    """
    if not is_number(value) or not (least is None or float(value) >= least):
        allowed = "" if least is None else f" of {least:g} or more"
        raise UserError(f"{name} must be a number{allowed}, got {value!r}")
    return float(value)


def whole(name: str, value: Any, least: int) -> int:
    """A whole number that was given, of Python or of numpy.

    Raises
    ------
    UserError
        If it is none, or less than `least`.
    """
    if not is_number(value, Integral) or value < least:
        raise UserError(f"{name} must be a whole number, {least} or more, got {value!r}")
    return int(value)


def flag(name: str, value: Any) -> bool:
    """A yes or no that was given, of Python or of numpy.

    Raises
    ------
    UserError
        If it is neither: a text such as "no" is a yes to Python.
    """
    if repr(value) not in ("True", "False", "np.True_", "np.False_"):
        raise UserError(f"{name} must be True or False, got {value!r}")
    return bool(value)


def instance(name: str, value: Any, kind: type[Wanted]) -> Wanted:
    """A value that is of the kind that is wanted.

    Raises
    ------
    UserError
        If it is not; a mapping of the right entries is not one either, and the message says how to make one of it.
    """
    if not isinstance(value, kind):
        remedy = f"; write {kind.__name__}(**...) around the mapping" if hasattr(value, "items") else ""
        raise UserError(f"{name} must be of the class {kind.__name__}, got {type(value).__name__}{remedy}")
    return value


def only_by_name(model: type[BaseModel], what: str, unnamed: Sequence[object]) -> None:
    """Raise `UserError` where values were given without a name to a model that takes its fields by name."""
    if unnamed:
        names = ", ".join(model.model_fields)
        raise UserError(f"{model.__name__} takes its {what} by name: {names}; got {unnamed[0]!r} without one")
