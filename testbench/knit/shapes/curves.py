"""A smooth curve of any shape over a range, linear in its weights."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import FloatArray
from testbench.knit.shapes.recent import Recent

CURVE_TERMS = 30
LAW_TERMS = 12  # of a law that is a curve of any form: it bends less quickly than a base law may


def curve(x: FloatArray, low: float, span: float, weights: tuple[float, ...]) -> FloatArray:
    """w_1 u + w_2 u^2 + sum_k w_k cos(k pi u) / k^2 with u = (x - low) / span, held flat outside 0 <= u <= 1.

    Weights of one size make a curve whose slope is a random walk: knees are as likely as bends, for contacts have
    knees. (Over k^3 its curvature would be one, which has none.)

    Parameters
    ----------
    x : ndarray, shape (n,)
    weights : tuple of float, length m

    Returns
    -------
    ndarray, shape (n,)

    Source: Wahba, Spline Models for Observational Data (1990), ch. 2.
    """
    if not any(weights):
        return np.zeros_like(x)
    from testbench.knit.shapes.splines import cosine_series

    return cosine_series(x, low, span, np.asarray(weights))


def curve_terms(x: FloatArray, low: float, span: float, count: int) -> FloatArray:
    """What each weight of a `curve` adds at weight 1, shape (count, n)."""
    from testbench.knit.shapes.splines import cosines

    return cosines(x, low, span, count)


kept_curve = Recent(curve)  # for an x that stays as weights of other curves change
