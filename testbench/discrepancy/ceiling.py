"""What any effect could explain: the residual mapped freely over its coordinates, judged like a candidate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbench.discrepancy.folds import Folds, across
from testbench.discrepancy.traces import FreeForm, Traces

FREE_RIDGES = (10.0, 300.0, 1e4)  # shares of the largest inner product per mille


def could_explain(traces: Traces) -> tuple[float, dict[tuple[str, str], float]]:
    """Loss of the flexible base with the whole free form, and with each of its groups alone.

    Returns
    -------
    ceiling : float
    depends_on : dict of (channel, group of coordinates) to float
    """
    free = traces.free
    if free is None:
        raise ValueError("these traces were collected without a free form")
    folds = Folds(traces, across(free.first, free.second), np.ones(len(traces.addresses), bool))
    groups = {name: _loss(free, folds, [name]) for name in dict.fromkeys(free.names)}
    return _loss(free, folds, list(groups)), groups


def _loss(free: FreeForm, folds: Folds, groups: Sequence[tuple[str, str]]) -> float:
    """Loss with some groups of the free form, shrunk by the ridge that judges best."""
    chosen = [1 + i for i, name in enumerate(free.names) if name in set(groups)]
    return min(sum(part.judged(chosen, part.shrunk(chosen, ridge)) for part in folds.parts) for ridge in FREE_RIDGES)
