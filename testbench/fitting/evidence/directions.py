"""The directions of a group of weights that the data can see.

The weights of a group have one prior, N(0, tau^2) each, so any rotation of them has the same. Along most eigenvectors
of their normal equations a rich shape changes nothing that is above the noise: only the others are kept.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from testbench.fitting.evidence.evidence import NormalEquations
from testbench.fitting.evidence.priors import Priors
from testbench.knit.effect import FloatArray

UNSEEN = 0.1  # of the prior's information: a direction with less is left out, at a loss of about as much of ln Z


@dataclass(frozen=True, eq=False)
class Directions:
    """An orthonormal basis of what is kept.

    Attributes
    ----------
    basis : ndarray, shape (p, q)
        Columns are directions; a parameter without a group is one by itself.
    group : ndarray of int, shape (q,)
        Group of each direction.
    member : ndarray of int, shape (p,)
        Group of each parameter.
    """

    basis: FloatArray
    group: np.ndarray
    member: np.ndarray

    @classmethod
    def seen(
        cls, columns: Mapping[str, FloatArray], information: Mapping[str, float], priors: Priors, scale: FloatArray
    ) -> Directions:
        """The directions in which the data say more than the prior.

        Parameters
        ----------
        columns : mapping of channel to ndarray, shape (p + 1, k)
            Residual and sensitivities.
        information : mapping of channel to float
            Independent samples that each sample stands for, over the variance of the noise.
        scale : ndarray
            Factor on the precision of each group, the smallest that may be needed.
        """
        own = np.flatnonzero(priors.group < 0)
        parts, group = [_unit(len(priors.group), own)], [np.full(len(own), -1)]
        for g in range(len(priors.groups)):
            where = np.flatnonzero(priors.group == g)
            gram = np.zeros((len(where), len(where)))
            for c, rows in columns.items():
                mine = rows[where[0] + 1 : where[-1] + 2]  # weights of a vector stand in a row
                if mine.any():
                    gram += information[c] * (mine @ mine.T)
            value, vector = np.linalg.eigh(gram)
            kept = value > UNSEEN * priors.precision[where[0]] * scale[g]
            part = np.zeros((len(priors.group), int(kept.sum())))
            part[where] = vector[:, kept]
            parts.append(part)
            group.append(np.full(part.shape[1], g))
        return cls(np.hstack(parts), np.concatenate(group), priors.group)

    @cached_property
    def own(self) -> np.ndarray:
        """A parameter of each direction, shape (q,): members of a group have one precision."""
        return np.argmax(self.basis != 0, axis=0)

    def rows(self, columns: FloatArray) -> FloatArray:
        """Residual and what each direction changes, shape (q + 1, k)."""
        found = np.empty((1 + len(self.group), columns.shape[1]))
        found[0] = columns[0]
        found[1:][self.group < 0] = columns[1:][self.member < 0]
        for g in np.unique(self.group[self.group >= 0]):
            mine, along = np.flatnonzero(self.member == g), np.flatnonzero(self.group == g)
            rows = columns[1 + mine[0] : 2 + mine[-1]]
            found[1 + along[0] : 2 + along[-1]] = self.basis[np.ix_(mine, along)].T @ rows if rows.any() else 0.0
        return found

    def along(self, vector: FloatArray) -> FloatArray:
        """Coordinates of a vector of all parameters, shape (q,)."""
        return self.basis.T @ vector

    def priors(self, mean: FloatArray, precision: FloatArray) -> tuple[FloatArray, FloatArray, np.ndarray]:
        """Prior mean, precision and group of each direction, all of shape (q,), from those of all parameters."""
        return self.along(mean), precision[self.own], self.group

    def normal(self, every: NormalEquations) -> NormalEquations:
        """The normal equations along the directions, from those of all parameters."""
        basis = np.zeros((1 + len(self.member), 1 + len(self.group)))
        basis[0, 0], basis[1:, 1:] = 1.0, self.basis
        products = {c: basis.T @ gram @ basis for c, gram in every.products.items()}
        mean, precision, group = self.priors(every.mean, every.precision)
        return replace(every, products=products, mean=mean, precision=precision, group=group)

    def full(self, coordinates: FloatArray) -> FloatArray:
        """All parameters from coordinates, shape (p,)."""
        return self.basis @ coordinates


def _unit(count: int, which: np.ndarray) -> FloatArray:
    part = np.zeros((count, len(which)))
    part[which, np.arange(len(which))] = 1.0
    return part
