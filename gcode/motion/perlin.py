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

LATTICE = 256  # period of the package's permutation table, in cells
LACUNARITY = 2.0
MAX_OCTAVES = 8
_CHUNK = 100_000  # a day at once would hold millions of Python floats
_SLOPE = (np.sqrt(5.0) - 1.0) / 2.0
_DIRECTION = np.array([1.0, _SLOPE]) / np.hypot(1.0, _SLOPE)


def perlin_walk(cells: np.ndarray, seed: Any, octaves: int, persistence: float) -> np.ndarray:
    """Perlin noise along a walk, about -0.9 to 0.9: the sum of the octaves divided by the sum of their amplitudes.

    Parameters
    ----------
    cells : array (n,)
        How many lattice cells of the first octave lie behind; each further octave is twice as fast.
    seed : int or sequence of int
        Chooses where each octave's walk through the noise starts, and its direction.
    octaves : int
        Number of octaves, 1 to 8: others crash the C code of `noise`.
    persistence : float
        Amplitude of an octave relative to the one before it; above 0, at most 1.

    Notes
    -----
    K. Perlin, "Improving noise", ACM Trans. Graph. 21(3), 2002, through the `noise` package. That package computes
    in float32, so arguments are reduced modulo the lattice's period in float64 first; without it the signal
    would be stepped after hours.
    """
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
