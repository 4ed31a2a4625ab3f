"""One column of a table in memory, as numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError


def numbers(source: str, name: str, values: Any) -> FloatArray:
    """One column of a data frame or a mapping, shape (n,); without a copy where it is an array of floats already.

    Parameters
    ----------
    source, name : str
        Named in the message.
    values : array, Series or sequence of numbers

    Raises
    ------
    UserError
        If they are no real numbers, or not one a sample.
    """
    given = np.asarray(values).dtype
    if given.kind in "mM":
        raise UserError(
            f"{source}: {name} must be numbers, got dates or durations ({given}); give seconds since the first sample"
        )
    if given.kind in "bc":
        raise UserError(f"{source}: {name} must be real numbers, got {given}; convert it, or leave it out")
    try:
        column = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise UserError(f"{source}: {name} must be numbers, {error}; convert it, or leave it out") from error
    if np.ma.isMaskedArray(values):
        column = np.where(np.ma.getmaskarray(values), np.nan, column)
    if column.ndim != 1:
        raise UserError(f"{source}: {name} must be one number a sample, got shape {column.shape}")
    return column
