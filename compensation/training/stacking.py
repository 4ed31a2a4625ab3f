"""The stack of `compensation.training.auto`: methods that predict together, each with a weight (stacking)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from compensation.training.learners import Line, Networks, Paper, Ridge
from gcode.support.arrays import FloatArray

STACK, STACKED = "stack", tuple(kind.name for kind in (Ridge, Paper, Networks))


def choose(predictions: Mapping[str, FloatArray], truth: FloatArray) -> str:
    """The stack where it predicts better than the line, by however little; else the line.

    The stack has learned from copies at other levels and paces, the line from the recording as it is: where one
    recording cannot tell the two apart, another one mostly can.
    """
    line, stack = (np.mean((truth - predictions[name]) ** 2) for name in (Line.name, STACK))
    return STACK if stack < line else Line.name


def weights_of(predictions: Mapping[str, FloatArray], truth: FloatArray) -> dict[str, float]:
    """The weights of the stack's parts that fit best, none negative, together 1; a part without weight is left out.

    With weights that sum to 1 the error of the stack is the weighted sum of the parts' errors. The sum s of weights
    that minimise ``|errors w|^2 + (1 - sum w)^2`` alone depends on the size of that error, not how they share it out:
    at shares v the best s leaves ``q / (1 + q)``, which rises with ``q = |errors v|^2``.

    Parameters
    ----------
    predictions : mapping of ndarray, each shape (paces, n)
    truth : ndarray, shape (n,)
    """
    from scipy.optimize import nnls

    errors = np.column_stack([(predictions[name] - truth).ravel() for name in STACKED])
    ones = np.full(len(STACKED), max(float(np.linalg.norm(errors)), 1e-12))
    found, _ = nnls(np.vstack([errors, ones]), np.append(np.zeros(len(errors)), ones[0]))
    return {name: float(w) for name, w in zip(STACKED, found / found.sum(), strict=True) if w > 0}


def stacked(predictions: Mapping[str, FloatArray], truth: FloatArray, folds: NDArray[np.int64]) -> FloatArray:
    """What the stack predicts of each fold at the pace of the recording, with weights from the other folds."""
    result = np.empty(len(truth))
    for number in np.unique(folds):
        here = folds == number
        weights = weights_of({name: predictions[name][:, ~here] for name in STACKED}, truth[~here])
        result[here] = sum(weight * predictions[name][0, here] for name, weight in weights.items())
    return result
