"""Inner products of residual, sensitivities and traces, block by block.

Once these small matrices are known, every question of the screening (fit on these blocks, judge on those) is linear
algebra on a few hundred numbers, however long the recordings are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from testbench.discrepancy.measurement import Measurement
from testbench.discrepancy.noise import whitened
from testbench.knit.effect import FloatArray

BLOCKS = 10


@dataclass(frozen=True)
class Grams:
    """Inner products of whitened columns in each block of one recording.

    Attributes
    ----------
    blocks : ndarray, shape (b, q, q)
        Column 0 is the residual, the next `base` columns are the base's sensitivities, the rest traces.
    samples : ndarray, shape (b,)
    base : int
        Number of sensitivities.
    """

    blocks: FloatArray
    samples: FloatArray
    base: int

    @property
    def total(self) -> FloatArray:
        """Sum over the blocks, shape (q, q)."""
        return self.blocks.sum(axis=0)


def grams(
    columns: Mapping[str, FloatArray],
    measurement: Measurement,
    filters: Mapping[str, FloatArray],
    scale: Mapping[str, float],
    base: int,
) -> Grams:
    """Whiten the columns of each channel, centre them over the recording, and multiply them block by block.

    Parameters
    ----------
    columns : mapping of channel to ndarray, shape (q, n)
        Residual, sensitivities, traces.
    filters, scale : mapping of channel
        Whitening filter and the spread of the whitened residual.
    base : int
        Number of sensitivities among the columns.
    """
    rows = np.flatnonzero(measurement.counts)
    parts = np.array_split(rows, BLOCKS)
    count = next(iter(columns.values())).shape[0]
    blocks = np.zeros((len(parts), count, count))
    for channel, values in columns.items():
        white = whitened(values, filters[channel]) / scale[channel]
        # Force zero and conductance gain belong to the mounting of each recording: they are free.
        white -= white[:, rows].mean(axis=1, keepdims=True)
        for index, part in enumerate(parts):
            piece = white[:, part[0] : part[-1] + 1]
            blocks[index] += piece @ piece.T
    return Grams(blocks, np.array([len(part) for part in parts], float), base)


def solve(
    gram: FloatArray, base: int, chosen: Sequence[int], signed: Sequence[bool], ridge: FloatArray
) -> FloatArray:
    """Coefficients of sensitivities and chosen traces that fit the residual best, shape (q,), zero elsewhere.

    Parameters
    ----------
    gram : ndarray, shape (q, q)
        Sum over the blocks to fit on.
    base : int
    chosen : sequence of int
        Columns of traces.
    signed : sequence of bool
        For each chosen trace, whether its coefficient may be negative.
    ridge : ndarray, shape (base,)
        Prior precision of the sensitivities' coefficients.
    """
    inner = np.arange(1, base + 1)
    matrix = gram[np.ix_(inner, inner)] + np.diag(ridge)
    # Solve for the base once; what is left is a small problem in the traces alone.
    rest = np.r_[0, np.asarray(chosen, int)]
    response = np.linalg.solve(matrix, gram[np.ix_(inner, rest)])
    schur = gram[np.ix_(rest, rest)] - gram[np.ix_(rest, inner)] @ response
    amounts = nonnegative(schur[1:, 1:], schur[1:, 0], np.asarray(signed, bool)) if len(chosen) else np.zeros(0)
    solution = np.zeros(len(gram))
    solution[inner] = response[:, 0] - response[:, 1:] @ amounts
    solution[rest[1:]] = amounts
    return solution


def nonnegative(matrix: FloatArray, target: FloatArray, signed: np.ndarray) -> FloatArray:
    """Coordinate descent for least squares with some coefficients held at or above zero.

    A small ridge keeps near-copies (neighbouring points of a grid) from fighting each other.
    """
    diagonal = np.maximum(np.diag(matrix), 1e-300)
    scale = 1 / np.sqrt(diagonal)
    normal = matrix * np.outer(scale, scale)
    normal[np.diag_indices_from(normal)] = 1.0 + 1e-3
    goal = target * scale
    x = np.zeros(len(goal))
    for _ in range(200):
        before = x.copy()
        for i in range(len(x)):
            value = x[i] + (goal[i] - normal[i] @ x) / normal[i, i]
            x[i] = value if signed[i] else max(value, 0.0)
        if np.max(np.abs(x - before), initial=0.0) < 1e-6 * (np.max(np.abs(x), initial=0.0) + 1e-12):
            break
    return x * scale


def loss(blocks: FloatArray, solution: FloatArray) -> FloatArray:
    """Squared misfit in each block for a solution, shape (b,)."""
    vector = -solution
    vector[0] = 1.0
    return np.einsum("i,bij,j->b", vector, blocks, vector)
