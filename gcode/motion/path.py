"""A path says where to be and how long to take, before any limit; a frame turns its strain into millimetres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np


@dataclass(frozen=True)
class Frame:
    """What turns a piece of a motion, told in strain, into positions of the machine in mm.

    Attributes
    ----------
    gauge_length_mm : float
        Length of the sample between the grips.
    offset_mm : float
        Pre-tension offset: the machine position of zero strain.
    rate_hz : float
        Sample rate of curved pieces.
    seed : tuple of int
        For this piece alone.
    v_max_mm_per_s, a_max_mm_per_s2 : float
        Limits that will be applied to the whole motion.
    """

    gauge_length_mm: float
    offset_mm: float
    rate_hz: float
    seed: tuple[int, ...]
    v_max_mm_per_s: float
    a_max_mm_per_s2: float

    def mm(self, strain_percent: Any) -> Any:
        """Machine position (mm) of a strain in percent."""
        return self.offset_mm + np.multiply(strain_percent, self.gauge_length_mm / 100.0)


class Path(NamedTuple):
    """n + 1 positions and the n durations between them. Equal positions in a row mean standing still."""

    position_mm: np.ndarray
    duration_s: np.ndarray


def way(stops_mm: list[float], speed_mm_per_s: float, rest_s: float = 0.0) -> Path:
    """Straight moves through `stops_mm` at one speed, then a rest; moves of no length are left out."""
    stops = np.array(stops_mm, dtype=float)
    stops = stops[np.concatenate(([True], np.abs(np.diff(stops)) > 1e-9))]
    moves = Path(stops, np.abs(np.diff(stops)) / speed_mm_per_s)
    return join(moves, rest(float(stops[-1]), rest_s))


def rest(at_mm: float, rest_s: float) -> Path:
    """Stand still; no path at all for no time."""
    return Path(np.full(2, at_mm), np.array([rest_s])) if rest_s > 0 else Path(np.array([at_mm]), np.zeros(0))


def join(*paths: Path) -> Path:
    """Chain paths whose ends meet."""
    positions = [paths[0].position_mm, *(path.position_mm[1:] for path in paths[1:])]
    return Path(np.concatenate(positions), np.concatenate([path.duration_s for path in paths]))
