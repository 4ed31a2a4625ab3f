"""The interval of a prediction on a recording to come, from errors on recordings or parts that were held out.

Recordings of several specimens differ in the level and the width of their errors, and a few of them tell poorly by
how much. So level and width of the next one are drawn from Student's t (the usual predictive distribution of a normal
variable whose mean and variance are both estimated), and its errors have the shape that theirs have together.

A single recording says nothing of that. How far gain and zero wander between days and specimens is known from other
sensors, though: it is the prior of a recalibration, and the interval draws from the same.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gcode.support.arrays import FloatArray

COVERAGE = 0.90
SHARES = ((1 - COVERAGE) / 2, (1 + COVERAGE) / 2)
DRAWS = 30_000


def of_one_recording(parts: Sequence[FloatArray], changes: Sequence[FloatArray]) -> tuple[float, float]:
    """Ends between which 90 % of the errors on another recording are expected, from the parts of a single one.

    Parts of one recording lie nearer to one another than the next one will: the widest of their own intervals is
    taken, and each error goes together with a draw of the gains and zeros that other days and specimens have.

    Parameters
    ----------
    parts : sequence of ndarray, each shape (n,)
        Errors on each part, by a method that had learned from the others.
    changes : sequence of ndarray, each shape (k, n)
        By how much each of them changes where one of those k numbers is a standard deviation off
        (`compensation.training.recalibration.one_sigma_changes`).
    """
    rng, ends = np.random.default_rng(0), []
    for errors, own in zip(parts, changes, strict=True):
        rows = rng.integers(len(errors), size=DRAWS)
        drawn = errors[rows] + np.sum(own[:, rows] * rng.standard_normal((len(own), DRAWS)), axis=0)
        ends.append(np.quantile(drawn, SHARES))
    return float(min(low for low, _ in ends)), float(max(high for _, high in ends))


def of_another(recordings: Sequence[FloatArray]) -> tuple[float, float]:
    """Ends between which 90 % of the errors on another recording are expected.

    Parameters
    ----------
    recordings : sequence of ndarray
        Errors on each recording, by a method that had learned from the others; three or more recordings.
    """
    rng, count = np.random.default_rng(0), len(recordings)
    levels = np.array([errors.mean() for errors in recordings])
    widths = np.array([max(float(errors.std()), 1e-12) for errors in recordings])
    each = DRAWS // count
    shape = np.concatenate(
        [
            rng.choice((errors - level) / width, each)
            for errors, level, width in zip(recordings, levels, widths, strict=True)
        ]
    )
    # A level lies count / (count - 1) times as far from the mean of the others, which it was predicted from, as from
    # the mean of all: scaled back.
    apart = levels * (count - 1) / count
    errors = _another(apart, len(shape), rng) + np.exp(_another(np.log(widths), len(shape), rng)) * shape
    low, high = np.quantile(errors, SHARES)
    return float(low), float(high)


def _another(values: FloatArray, draws: int, rng: np.random.Generator) -> FloatArray:
    """Draws of one further value, as Student's t predicts it from a few that are thought to be normal."""
    count = len(values)
    spread = float(values.std(ddof=1)) * np.sqrt(1 + 1 / count)
    return values.mean() + spread * rng.standard_t(count - 1, draws)
