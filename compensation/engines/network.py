"""A small feed-forward network as plain arrays: what is saved, streamed and exported."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gcode.support.arrays import FloatArray
from gcode.support.read_only import Unchanging

DEAD_SPREAD = 0.05
# More units or hidden layers than these have no place on a chip, and fill the memory instead.
WIDEST, DEEPEST = 256, 8


@dataclass(frozen=True, eq=False)
class Network(Unchanging):
    """A multilayer perceptron with relu hidden layers and a linear output."""

    weights: tuple[FloatArray, ...]  # one a layer, each (inputs, outputs)
    biases: tuple[FloatArray, ...]  # one a layer, each (outputs,)

    @property
    def sizes(self) -> tuple[int, ...]:
        return tuple(len(bias) for bias in self.biases[:-1])

    @property
    def parameter_count(self) -> int:
        return sum(w.size for w in self.weights) + sum(b.size for b in self.biases)

    def __call__(self, features: FloatArray) -> FloatArray:
        """Output for each row of `features` (n, k): shape (n,)."""
        values = features
        for weight, bias in zip(self.weights[:-1], self.biases[:-1], strict=True):
            values = np.maximum(values @ weight + bias, 0.0)
        return (values @ self.weights[-1] + self.biases[-1])[:, 0]

    def is_dead(self, features: FloatArray) -> bool:
        """Whether the output hardly moves over `features`: (nearly) every path to it is switched off.

        The target has unit variance, so an output with a standard deviation below 0.05 explains almost nothing of it.
        """
        return bool(np.std(self(features)) < DEAD_SPREAD)

    def absorbing(self, shift: FloatArray, scale: FloatArray) -> Network:
        """The same function of raw inputs, where this one takes ``(inputs - shift) * scale``."""
        first = self.weights[0] * scale[:, None]
        return Network((first, *self.weights[1:]), (self.biases[0] - shift @ first, *self.biases[1:]))

    def reading(self, columns: NDArray[np.bool_]) -> Network:
        """The same function of more inputs: it takes those that are marked, and the others have no weight."""
        first = np.zeros((len(columns), self.weights[0].shape[1]))
        first[columns] = self.weights[0]
        return replace(self, weights=(first, *self.weights[1:]))

    def times(self, factor: float) -> Network:
        """The same function, its output multiplied by `factor`."""
        *weights, last_weight = self.weights
        *biases, last_bias = self.biases
        return Network((*weights, last_weight * factor), (*biases, last_bias * factor))

    @classmethod
    def from_lists(cls, weights: Sequence, biases: Sequence) -> Network:
        """Inverse of `to_dict`.

        Raises
        ------
        ValueError
            If the shapes do not form a network with one output, or a number is not finite.
        """
        if any(len({len(row) for row in matrix}) > 1 for matrix in weights):
            raise ValueError("a layer has rows of weights of different lengths")
        w = tuple(np.asarray(matrix, dtype=np.float64) for matrix in weights)
        b = tuple(np.asarray(vector, dtype=np.float64) for vector in biases)
        if not w or len(w) != len(b):
            raise ValueError("a network needs as many weight matrices as bias vectors, at least one")
        for matrix, vector in zip(w, b, strict=True):
            if matrix.ndim != 2 or vector.shape != matrix.shape[1:]:
                raise ValueError(f"a layer has weights of shape {matrix.shape} and biases of shape {vector.shape}")
            if not (np.isfinite(matrix).all() and np.isfinite(vector).all()):
                raise ValueError("a weight or bias is not a finite number")
        if any(left.shape[1] != right.shape[0] for left, right in pairwise(w)) or len(b[-1]) != 1:
            raise ValueError("the layers do not fit together into one output")
        return cls(w, b)


def alive(networks: Sequence[Network], features: FloatArray) -> tuple[Network, ...]:
    """Those that are not dead; the first where all are."""
    return tuple(network for network in networks if not network.is_dead(features)) or tuple(networks[:1])


def mean_output(networks: Sequence[Network], features: FloatArray) -> FloatArray:
    """Mean over networks of their outputs for each row of `features` (n, k): shape (n,)."""
    return np.mean([network(features) for network in networks], axis=0)
