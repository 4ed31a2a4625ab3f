"""What a compensator remembers of its training: the ranges it saw, and where memories are expected to begin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcode.support.arrays import FloatArray
from gcode.support.read_only import Unchanging

# Of the range seen in training, as much to either side still goes into the memories.
MARGIN_WIDTHS = 1.0


@dataclass(frozen=True, eq=False)
class Seen(Unchanging):
    """Ranges over the training recordings.

    Attributes
    ----------
    low, high : float
        Of the standardised conductance.
    inputs_low, inputs_high : ndarray, shape (input_count,)
        Of each input of the networks.
    """

    low: float
    high: float
    inputs_low: FloatArray
    inputs_high: FloatArray

    def held(self, x: FloatArray) -> FloatArray:
        """`x`, clipped `MARGIN_WIDTHS` widths of the range outside of it."""
        margin = MARGIN_WIDTHS * (self.high - self.low)
        return np.clip(x, self.low - margin, self.high + margin)


@dataclass(frozen=True, eq=False)
class Beginning(Unchanging):
    """What each memory is expected to hold, given the standardised conductance x at the start: offset + gain x.

    Attributes
    ----------
    gain, offset : ndarray, shape (input_count,)
        In the order of the networks' inputs. A filter's x is the mean of its first M samples.
    """

    gain: FloatArray
    offset: FloatArray
