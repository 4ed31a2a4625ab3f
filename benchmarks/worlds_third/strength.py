"""How strong an effect is: what smooth base functions cannot absorb of it, in noise floors; and how large it must be.

The base that absorbs is this file's own: a cubic in strain, the reading without the effect and its square (so an
amplitude, an offset or a curvature of the base hides nothing), the direction of motion over two distances with a
slope over strain, and two logarithms and the square root of time. One set of weights serves both recordings; a
specimen clamped anew has a quadratic in strain of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from worlds_third import kernels
from worlds_third.signals import Array, Signals

MOST_ROWS = 30_000  # of each recording; more do not change an RMS
CLOSE = 0.01  # of the strength asked for
STEPS = 40
START = 1e-5  # first size tried, over the form's limit


class Absorption:
    """Takes from a difference of readings what base functions can explain."""

    def __init__(self, base: Sequence[Signals], floors: Mapping[str, float], reclamped: bool) -> None:
        self.floors = floors
        self._every = [max(1, len(s.time_s) // MOST_ROWS) for s in base]
        self._base = {name: self._thinned(base, name) for name in floors}
        self._planes = {name: self._plane(base, name, reclamped) for name in floors}

    def left(self, changed: Sequence[Signals]) -> dict[str, float]:
        """RMS of what is left of the change of each channel, in noise floors."""
        return {name: self._left(changed, name) for name in self.floors}

    def _thinned(self, both: Sequence[Signals], name: str) -> Array:
        return np.concatenate([_reading(s, name)[::k] for s, k in zip(both, self._every, strict=True)])

    def _left(self, changed: Sequence[Signals], name: str) -> float:
        change = self._thinned(changed, name) - self._base[name]
        plane = self._planes[name]
        change = change - plane @ (plane.T @ change)
        return float(np.sqrt(np.mean(change**2))) / self.floors[name]

    def _plane(self, base: Sequence[Signals], name: str, reclamped: bool) -> Array:
        rows = [np.column_stack(_columns(s, _reading(s, name)))[::k] for s, k in zip(base, self._every, strict=True)]
        columns = np.concatenate(rows)
        if reclamped:
            own = np.concatenate([np.zeros((len(rows[0]), 3)), rows[1][:, :3]])
            columns = np.column_stack([columns, own])
        columns = columns / np.sqrt(np.mean(columns**2, axis=0) + 1e-30)
        directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
        return directions[:, sizes > 1e-9 * sizes[0]]


def _reading(s: Signals, name: str) -> Array:
    return s.force if name == "force" else s.log_g


def _columns(s: Signals, reading: Array) -> list[Array]:
    x, t = s.drive, s.time_s
    ways = [kernels.direction(x, reach) for reach in (0.03, 0.1)]
    polynomial = [np.ones_like(x), x, x**2, x**3]
    times = [np.log1p(t / 5.0), np.log1p(t / 100.0), np.sqrt(t)]
    return [*polynomial, reading, reading**2, *ways, ways[1] * x, *times]


def size_for(strength: float, limit: float, measured: Callable[[float], float]) -> tuple[float, float]:
    """The smallest size that reaches the strength, and the strength reached.

    Parameters
    ----------
    strength : float
        In noise floors.
    limit : float
        The largest size allowed; where even that is too weak, the strongest tried is returned.
    measured : callable
        Size to strength; 0 at 0.

    Notes
    -----
    Goes up from a small size, never more than tenfold, until the strength is passed; then regula falsi (Illinois) in
    logarithms, or plain halving where an effect comes in jumps.
    """
    size, tried = START * limit, [(0.0, 0.0)]
    while True:
        tried.append((size, measured(size)))
        if tried[-1][1] >= strength * (1 - CLOSE):
            break
        if size >= limit:
            return max(tried, key=lambda pair: pair[1])
        size = min(limit, size * float(np.clip(1.02 * strength / max(tried[-1][1], 1e-9), 1.3, 10.0)))
    return _narrowed(strength, tried[-2], tried[-1], measured)


def _narrowed(
    strength: float, low: tuple[float, float], high: tuple[float, float], measured: Callable[[float], float]
) -> tuple[float, float]:
    best = high
    for step in range(STEPS):
        if abs(best[1] / strength - 1) <= CLOSE:
            break
        size = _between(strength, low, high, halve=step % 3 == 2)
        now = (size, measured(size))
        low, high = (now, high) if now[1] < strength else (low, now)
        best = min((best, now), key=lambda pair: abs(np.log(max(pair[1], 1e-12) / strength)))
    return best


def _between(strength: float, low: tuple[float, float], high: tuple[float, float], halve: bool) -> float:
    """A size between two, where a straight line in logarithms (or their middle) says."""
    bottom = max(low[0], 1e-3 * high[0])
    if halve or low[1] <= 0 or high[1] <= low[1]:
        return float(np.sqrt(bottom * high[0]))
    share = np.log(strength / low[1]) / np.log(high[1] / low[1])
    return float(bottom * (high[0] / bottom) ** np.clip(share, 0.03, 0.97))
