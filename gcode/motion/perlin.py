"""A seeded Perlin signal that does not repeat within a day.

The `noise` package's one-dimensional noise repeats every 256 lattice cells and its ``base`` is a shift, not a
seed. Here each octave is a straight walk through a plane of noise instead, along the golden slope, which never meets
its own lattice phase again. All walks through one plane are parallel, so two seeds can lie on top of each other (a
correlation of 0.99 was seen among 20 seeds over 3 h); therefore each seed and octave draws one of the 256 lattice
planes of three-dimensional noise and one of eight directions.
"""

from __future__ import annotations

from itertools import repeat
from typing import Any

import numpy as np
from noise import pnoise3

from gcode.support.errors import UserError

LATTICE = 256  # period of the package's permutation table, in cells
LACUNARITY = 2.0
MAX_OCTAVES = 8
_CHUNK = 100_000  # a day at once would hold millions of Python floats
_SLOPE = (np.sqrt(5.0) - 1.0) / 2.0
_DIRECTION = np.array([1.0, _SLOPE]) / np.hypot(1.0, _SLOPE)


def perlin_signal(
    time_s: np.ndarray, seed: Any, cells_per_s: float, octaves: int = 1, persistence: float = 0.5
) -> np.ndarray:
    """Perlin noise over time, about -0.9 to 0.9.

    Parameters
    ----------
    time_s : array (n,)
        Times; any spacing.
    seed : int or numpy.random.SeedSequence
        Chooses where each octave's walk through the noise starts, and its direction.
    cells_per_s : float
        Lattice cells crossed per second by the first octave; each further octave is twice as fast.
    octaves : int
        Number of octaves, 1 to 8.
    persistence : float
        Amplitude of an octave relative to the one before it.

    Returns
    -------
    array (n,)
        The sum of the octaves divided by the sum of their amplitudes.

    Notes
    -----
    K. Perlin, "Improving noise", ACM Trans. Graph. 21(3), 2002, through the `noise` package. That package computes
    in float32, so arguments are reduced modulo the lattice's period in float64 first; without it the signal
    would be stepped after hours.
    """
    check_noise_parameters(cells_per_s, octaves, persistence)
    return perlin_walk(np.asarray(time_s, dtype=float) * cells_per_s, seed, octaves, persistence)


def perlin_walk(cells: np.ndarray, seed: Any, octaves: int, persistence: float) -> np.ndarray:
    """Perlin noise along a walk: `cells` (n,) says how many lattice cells of the first octave lie behind."""
    rng = np.random.default_rng(seed)
    total = np.zeros(len(cells))
    amplitudes = persistence ** np.arange(octaves)
    for octave in range(octaves):
        direction = rng.permutation(_DIRECTION) * rng.choice((-1.0, 1.0), 2)
        start, plane = rng.uniform(0.0, LATTICE, 2), float(rng.integers(LATTICE))
        total += amplitudes[octave] * _walk(cells * LACUNARITY**octave, start, direction, plane)
    return total / amplitudes.sum()


def _walk(cells: np.ndarray, start: np.ndarray, direction: np.ndarray, plane: float) -> np.ndarray:
    level = np.empty(len(cells))
    for begin in range(0, len(cells), _CHUNK):
        part = cells[begin : begin + _CHUNK]
        xs = ((part * direction[0] + start[0]) % LATTICE).tolist()
        ys = ((part * direction[1] + start[1]) % LATTICE).tolist()
        level[begin : begin + _CHUNK] = np.fromiter(map(pnoise3, xs, ys, repeat(plane)), float, len(part))
    return level


def check_noise_parameters(cells_per_s: float, octaves: int, persistence: float) -> None:
    """Refuse what would crash the C code of `noise` or pass through it as nan."""
    if not (np.isfinite(cells_per_s) and cells_per_s > 0):
        raise UserError(f"cells_per_s must be a finite number above 0, got {cells_per_s}")
    if isinstance(octaves, bool) or octaves != int(octaves) or not 1 <= octaves <= MAX_OCTAVES:
        raise UserError(f"octaves must be a whole number from 1 to {MAX_OCTAVES}, got {octaves}")
    if not (np.isfinite(persistence) and 0 < persistence <= 1):
        raise UserError(f"persistence must be above 0 and at most 1, got {persistence}")
