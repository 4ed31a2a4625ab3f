"""Files with several repeats below each other, each on a time of its own: every repeat is a recording."""

from __future__ import annotations

import numpy as np


def repeats_of(counter: np.ndarray, time_s: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Repeats that a column numbers, where the time starts again with each; empty where it does not.

    Parameters
    ----------
    counter, time_s : ndarray, each shape (n,)

    Returns
    -------
    list of (label, rows)
        The number of the repeat, and which rows are its.
    """
    restarts = np.flatnonzero(np.diff(time_s) < 0)
    changes = np.flatnonzero(np.diff(counter) != 0)
    whole = np.isfinite(counter).all() and (counter == np.round(counter)).all()
    numbers = list(dict.fromkeys(counter.tolist()))
    if not whole or not restarts.size or not set(restarts) <= set(changes) or len(numbers) != len(changes) + 1:
        return []
    return [(f"{int(number)}", np.flatnonzero(counter == number)) for number in numbers]
