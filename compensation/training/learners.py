"""The methods that `compensation.training.auto` chooses among, each fitted on recordings and applied to others.

Each makes its own choices (scalers, L2, memories) on the recordings that it is given, and predicts a part that was
held out as a recording of its own, its memories beginning with its first sample: as it was recorded, and as if it had
been slower or quicker.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compensation.engines.engine import ENGINES
from compensation.engines.network import Network, alive, mean_output
from compensation.memories.history import NO_HISTORY, QUICK_SETTLE_S, History
from compensation.series import score
from compensation.series.preprocessing import Series
from compensation.training.folds import FOLDS, contiguous
from compensation.training.lessons import Lessons, features_at_pace, lessons
from compensation.training.options import PAPER_SIZES, Options
from compensation.training.tuning import PLAY_RADII
from gcode.support.arrays import FloatArray

Mask = NDArray[np.bool_]

# A knit answers to motion within a tenth of a second and for half a minute: developed on specimens 101 to 104 of both
# presets, where these gained 0.05 to 0.12 r2 of force over the four slower ones of `tuned`.
DENSE_MOTION_TAUS_S = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 32.0)
WHOLE = History(DENSE_MOTION_TAUS_S, PLAY_RADII, QUICK_SETTLE_S)
# The paper's seven filters, and one more between each two.
FACTOR, COUNT = float(np.sqrt(2.5)), 14
PAPERS = np.arange(1, COUNT, 2)
WIDE_STATE_SHIFT = 0.2
# Another recording may move slower or quicker. About one step of the bank to either side, so that no memory is
# blurred by more than the bank itself does. Of 1.5 and 2 on specimen 101, 2 cost 0.02 of r2.
SLOWER = 1.5
PACES = (1.0, SLOWER, 1 / SLOWER)
RIDGE_PENALTIES = (1e-4, 1e-3, 1e-2, 3e-2, 0.1, 0.3)
# Two of each, so that the whole stays below 1,500 numbers.
NETWORK_SIZES, ENSEMBLE_OF_TWO_SIZES = ((8,), (12, 8)), 4
NETWORK_PENALTIES = (0.1, 0.3, 1.0)
STARTS = 5


@dataclass(frozen=True)
class Learned:
    """A fitted method: networks on standardised features, and the settings that it chose."""

    networks: tuple[Network, ...]
    settings: Mapping[str, Any]


class Learner:
    """One method on one set of recordings, which are all that it learns from.

    Features of the same memories are taken from `like`, another one on the same recordings, and not made again.
    """

    name = ""
    options = Options()
    lessons: Lessons

    def __init__(self, series: Sequence[Series], target: str, options: Options, like: Learner | None = None) -> None:
        self.options = replace(self.options, rate_hz=options.rate_hz, irregular=options.irregular, seed=options.seed)
        if like is not None and _memories(like.options) == _memories(self.options):
            self.lessons = like.lessons
            return
        self.lessons = lessons(series, target, self.options, starts=True, shift=WIDE_STATE_SHIFT, paces=PACES[1:])

    @property
    def features(self) -> FloatArray:
        """Of the recordings as they are, standardised by the lessons: shape (n, k)."""
        return self.lessons.versions[0]

    def fit(self) -> Learned:
        """Learn from the recordings; networks take standardised features."""
        raise NotImplementedError

    def predict(self, learned: Learned, parts: Sequence[Series]) -> FloatArray:
        """Target of what was held out at each pace, in its unit: shape (paces, rows)."""
        lesson = self.lessons
        fresh = [(features_at_pace(lesson.blank, parts, pace) - lesson.shift) * lesson.scale for pace in PACES]
        return lesson.blank.scaling_out.invert(np.stack([mean_output(learned.networks, x) for x in fresh]))


class Line(Learner):
    """A straight line through the conductance."""

    name, options = "line", Options(alphas=(1.0,), sizes=(), l2=0.0)

    def fit(self) -> Learned:
        x, y = self.features[:, 0], self.lessons.truth
        slope = float(np.mean((x - x.mean()) * (y - y.mean())) / max(float(x.var()), 1e-12))
        return Learned((linear(np.array([slope]), float(y.mean() - slope * x.mean())),), {"l2": 0.0})


class Ridge(Learner):
    """Ridge regression on bank, motion and play; its penalty is cross-validated within the recordings."""

    name, options = "ridge", Options(factor=FACTOR, count=COUNT, history=WHOLE, sizes=())

    def fit(self) -> Learned:
        fold = contiguous(len(self.features), FOLDS)
        parts = np.stack([products_of(self.lessons, fold == number) for number in range(FOLDS)])
        errors = [self.error(parts, l2) for l2 in RIDGE_PENALTIES]
        l2 = RIDGE_PENALTIES[int(np.argmin(errors))]
        return Learned((linear(*solved(parts.sum(axis=0), l2)),), {"l2": l2})

    @staticmethod
    def error(parts: FloatArray, l2: float) -> float:
        """Squared error on the recording as it is, of every fold by what the others say."""
        held_out = 0.0
        for number, (_, judge) in enumerate(parts):
            weights, bias = solved(np.delete(parts, number, axis=0).sum(axis=0), l2)
            w = np.concatenate([weights, [bias, -1.0]])
            held_out += float(w @ judge @ w)
        return held_out


def products_of(lesson: Lessons, rows: Mask) -> FloatArray:
    """Sums over some rows of products of the features, a one and the target: shape (2, k + 2, k + 2).

    First averaged over all versions of the recording, to learn from, then of the recording as it is. Folds of a ridge
    regression are added and taken away without going through rows again.
    """
    products = []
    for version in lesson.versions:
        x = np.column_stack([version[rows], np.ones(rows.sum()), lesson.truth[rows]])
        products.append(x.T @ x)
    return np.stack([np.mean(products, axis=0), products[0]])


def solved(products: FloatArray, l2: float) -> tuple[FloatArray, float]:
    """Weights and bias; the penalty is on features of unit variance, in shares of the number of rows."""
    learn, _ = products
    count = learn[-2, -2]
    mean = learn[:-2, -2] / count
    covariance = learn[:-2, :-2] / count - np.outer(mean, mean)
    target_mean = learn[-1, -2] / count
    cross = learn[:-2, -1] / count - mean * target_mean
    spread = np.sqrt(np.maximum(np.diag(covariance), 1e-12))
    scaled = covariance / np.outer(spread, spread) + l2 * np.eye(len(spread))
    weights = np.linalg.solve(scaled, cross / spread) / spread
    return weights, float(target_mean - mean @ weights)


class Paper(Learner):
    """The paper's network on the paper's bank, best of five starts by training score."""

    name, options = "paper", Options(factor=FACTOR, count=COUNT, history=WHOLE, sizes=PAPER_SIZES, engine="fast")

    def fit(self) -> Learned:
        x, y, options = self.features[:, PAPERS], self.lessons.truth, self.options
        fits = [
            ENGINES[options.engine](x, y, options.sizes, options.seed + start, options.l2) for start in range(STARTS)
        ]
        best = max(fits, key=lambda fit: score.r2(y, fit.network(x)))
        own = np.isin(np.arange(self.features.shape[1]), PAPERS)
        return Learned((best.network.reading(own),), {"l2": options.l2, "restarts": STARTS})


class Networks(Learner):
    """Several small networks of two sizes; memories and L2 from halves of the rows."""

    name = "networks"
    options = Options(factor=FACTOR, count=COUNT, history=WHOLE, sizes=NETWORK_SIZES[0], engine="fast")

    def fit(self) -> Learned:
        history, l2 = self._chosen()
        everything = np.ones(len(self.features), dtype=bool)
        networks = tuple(
            self._one(everything, history, l2, self.options.seed + number, NETWORK_SIZES[number % len(NETWORK_SIZES)])
            for number in range(ENSEMBLE_OF_TWO_SIZES)
        )
        settings = {"l2": l2, "restarts": len(networks), "memories": history.count, "members": NETWORK_SIZES}
        return Learned(alive(networks, self.features), settings)

    def _chosen(self) -> tuple[History, float]:
        """Choose the memories at a medium L2 penalty, then the penalty."""
        middle = NETWORK_PENALTIES[1]
        errors = {(history, middle): self._error(history, middle) for history in (NO_HISTORY, WHOLE)}
        history, _ = min(errors, key=lambda key: errors[key])
        errors |= {(history, l2): self._error(history, l2) for l2 in NETWORK_PENALTIES if l2 != middle}
        return min(errors, key=lambda key: errors[key])

    def _error(self, history: History, l2: float) -> float:
        total, half = 0.0, contiguous(len(self.features), 2)
        for number in (0, 1):
            network = self._one(half != number, history, l2, 0, NETWORK_SIZES[0])
            rows = half == number
            total += float(np.sum((self.lessons.truth[rows] - network(self.features[rows])) ** 2))
        return total

    def _one(self, kept: Mask, history: History, l2: float, seed: int, sizes: tuple[int, ...]) -> Network:
        used = np.arange(self.features.shape[1]) < COUNT + history.count
        lesson = replace(self.lessons, versions=tuple(version[:, used] for version in self.lessons.versions))
        return lesson.fit(kept, replace(self.options, l2=l2, sizes=sizes), seed).reading(used)


def linear(weights: FloatArray, bias: float) -> Network:
    """A network without a hidden layer."""
    return Network((weights[:, None],), (np.array([bias]),))


def _memories(options: Options) -> tuple[Any, ...]:
    return options.factor, options.count, options.alphas, options.history
