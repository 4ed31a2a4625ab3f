"""The choices of a training run."""

from __future__ import annotations

from dataclasses import dataclass

from compensation.engines.engine import DEFAULT_L2
from compensation.memories import ema
from compensation.memories.history import NO_HISTORY, History
from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError

PAPER_SIZES = (4, 2, 2)
HIGHEST_SEED = 2**31 - 1


@dataclass(frozen=True)
class Options:
    """Choices of a training run; the defaults are the paper's, with restarts."""

    sizes: tuple[int, ...] = PAPER_SIZES  # hidden layers
    factor: float = ema.PAPER_FACTOR  # smoothing factors ``alpha_i = factor^-i``, i = 1..count
    count: int = ema.PAPER_COUNT
    l2: float = DEFAULT_L2  # MLPRegressor's ``alpha``
    seed: int = 0  # of the first start; the others follow it
    restarts: int = 5  # networks trained, of which the one with the best training score is kept; the paper: 1
    irregular: bool = False  # use the samples at their own times instead of resampling
    per_recording: bool = False  # standardise each recording by itself, which needs the whole recording
    engine: str = "exact"  # or "fast" or "sklearn"
    rate_hz: float = ema.PAPER_RATE_HZ  # of resampling, and the one that the smoothing factors refer to
    history: History = NO_HISTORY  # memories beside the bank; the paper has none
    alphas: tuple[float, ...] | None = None  # smoothing factors set by hand, in place of those

    @property
    def resampling_hz(self) -> float | None:
        """Rate that recordings are resampled to; None where they are taken as sampled."""
        return None if self.irregular else self.rate_hz

    def check_for_use(self, method: str) -> None:
        """Refuse what a method that learns for use cannot do; `method` as the command line says it.

        Raises
        ------
        UserError
            If each recording is to be standardised by itself.
        """
        if self.per_recording:
            raise UserError(
                f"--per-recording is for --method paper only: {method} learns for use, where no recording's own mean "
                "is known; leave --per-recording out"
            )

    @property
    def bank(self) -> FloatArray:
        """The smoothing factors: those set by hand, or calculated from factor and count."""
        if self.alphas is None:
            return ema.smoothing_factors(self.factor, self.count)
        return ema.given_factors(self.alphas)

    @property
    def slowest_s(self) -> float:
        """Time constant (s) of the bank's slowest filter."""
        return ema.slowest_memory_s(self.bank, self.rate_hz)
