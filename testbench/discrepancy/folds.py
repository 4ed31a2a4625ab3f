"""The base and the candidates fitted on some blocks of the recordings and judged on others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbench.discrepancy.grams import Grams, reduce_to_traces
from testbench.discrepancy.traces import Traces
from testbench.knit.effect import FloatArray

Pair = tuple[FloatArray, FloatArray]  # inner products to fit on, and to judge on


def across(first: Grams, second: Grams) -> list[Pair]:
    """Fit on either recording, judge on the other."""
    totals = first.total, second.total
    return [totals, totals[::-1]]


def within(first: Grams, second: Grams) -> list[Pair]:
    """Fit on every other block of a recording, judge on the rest of the same recording."""
    return [pair for part in (first, second) for pair in ((part.even, part.odd), (part.odd, part.even))]


class Folds:
    """The same base fitted and judged on several pairs of block sets.

    Only the candidates `only` (indices; default all) can be judged: fewer columns are quicker.
    """

    def __init__(
        self,
        traces: Traces,
        pairs: Sequence[Pair],
        kept: np.ndarray,
        only: Sequence[int] | None = None,
    ) -> None:
        size = traces.first.base
        self._place = None
        if only is not None:
            self._place = {1 + index: 1 + place for place, index in enumerate(only)}
            pick = np.ix_(*2 * [[*range(size + 1), *(size + 1 + i for i in only)]])
            pairs = [(fit[pick], judge[pick]) for fit, judge in pairs]
        self.parts = [reduce_to_traces(fit, judge, size, traces.ridge, kept, traces.weights) for fit, judge in pairs]
        self.bare = self.loss([], [])

    def loss(self, chosen: Sequence[int], signed: Sequence[bool]) -> float:
        places = self._places(chosen)
        return sum(part.judged(places, part.amounts(places, signed)) for part in self.parts)

    def amount(self, one: int, signed: bool) -> float:
        """Amount of one column as the first pair would have it."""
        return float(self.parts[0].amounts(self._places([one]), [signed])[0])

    def _places(self, chosen: Sequence[int]) -> Sequence[int]:
        return chosen if self._place is None else [self._place[index] for index in chosen]
