"""Weighted inner products of the columns of a linearised model: what the normal equations are made of."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import FloatArray


def gram(rows: FloatArray, root_weight: FloatArray) -> FloatArray:
    """Weighted inner products of rows (p, k), shape (p, p); a channel answers to few of the parameters."""
    answers = np.flatnonzero(rows.any(axis=1))
    weighted = rows[answers] * root_weight
    gram = np.zeros((len(rows), len(rows)))
    gram[np.ix_(answers, answers)] = weighted @ weighted.T
    return gram


class ProductsOfShapes:
    """Inner products of the directions of the shapes, made once; outliers count less in them from then on.

    Parameters
    ----------
    rows : ndarray, shape (q, k)
        Along the directions.
    """

    def __init__(self, rows: FloatArray) -> None:
        self.count, self.answers = len(rows), np.flatnonzero(rows.any(axis=1))
        self.rows = rows[self.answers]
        self.unweighted = self.rows @ self.rows.T

    def beside(self, rows: FloatArray, root_weight: FloatArray) -> FloatArray:
        """Weighted inner products of all rows, of which the last are those of the shapes; shape (p + q, p + q)."""
        own, gram = len(rows) - self.count, np.zeros((len(rows), len(rows)))
        place, weighted = own + self.answers, rows[:own] * root_weight**2
        gram[:own, :own] = weighted @ rows[:own].T
        gram[:own, place] = weighted @ self.rows.T
        gram[place, :own] = gram[:own, place].T
        outliers = np.flatnonzero(root_weight < 1)
        less = self.rows[:, outliers] * np.sqrt(1 - root_weight[outliers] ** 2)
        gram[np.ix_(place, place)] = self.unweighted - less @ less.T
        return gram
