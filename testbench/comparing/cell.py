"""One stretch of a coordinate, and the residual there."""

from __future__ import annotations

from dataclasses import dataclass

HOLD_RATE = 2e-4  # 1/s; a strain that changes more slowly is held


@dataclass(frozen=True)
class Cell:
    """One bin of a residual map.

    Attributes
    ----------
    low, high : float
        Edges of the bin in the coordinate's unit.
    direction : int
        +1 stretching, -1 releasing, 0 both.
    mean, standard_error : float
        Of measured minus modelled, N or ln S; the error from blocks of `CELL_BLOCK_S`.
    share : float
        Share of the samples.
    """

    low: float
    high: float
    direction: int
    mean: float
    standard_error: float
    share: float

    @property
    def t(self) -> float:
        """Mean over its standard error."""
        return self.mean / self.standard_error if self.standard_error > 0 else 0.0
