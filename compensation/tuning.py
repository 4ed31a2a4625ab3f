"""The better compensator: more paths, stronger L2, several networks; every choice from the training recording alone.

The paper's (4, 2, 2) network dies at birth in one start of five to ten and differs much from seed to seed. A slightly
larger network with a stronger penalty does neither, and the mean over several starts is better than any one of them.
The bank, then the penalty, are chosen by cross-validation over contiguous blocks: neighbouring samples are alike, so
folds of single samples would judge nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from compensation.compensator import Compensator
from compensation.engines import Fit, engine
from compensation.preprocessing import Series
from compensation.score import r2
from compensation.training import Options, describe, training_arrays, untrained

FloatArray = NDArray[np.float64]

BANKS = ((2.5, 7), (1.75, 10), (1.5, 14))
PENALTIES = (0.1, 0.03, 0.3, 1.0)
SIZES = (16, 8)
FOLDS, ENSEMBLE = 4, 8


@dataclass(frozen=True)
class Choice:
    """One combination and its cross-validated r2."""

    options: Options
    r2: float


def tune(
    series: Sequence[Series],
    target: str,
    options: Options,
    progress: Callable[[str], None] = lambda note: None,
) -> Compensator:
    """Choose the bank and then the penalty by blocked cross-validation, then average `ENSEMBLE` networks.

    Parameters
    ----------
    series : sequence of Series
        Training recordings; nothing else is looked at.
    target : {"force", "displacement"}
    options : Options
        Seed, engine, sampling; its sizes, factors and penalty are replaced by the chosen ones.
    progress : callable
        Told about each combination and each network: `steps` times.
    """
    choices: list[Choice] = []
    chosen = _best_of(banks(options), choices, series, target, progress)
    chosen = _best_of(penalties(chosen.options), choices, series, target, progress)
    blank = untrained(series, target, chosen.options)
    features, truth = training_arrays(blank, series)
    fits = []
    for seed in range(options.seed, options.seed + ENSEMBLE):
        fits.append(_fit(features, truth, chosen.options, seed))
        progress(f"network {seed}")
    live = [fit for fit in fits if not fit.network.is_dead(features)] or fits
    trained = replace(blank, networks=tuple(fit.network for fit in live))
    mean = np.mean([network(features) for network in trained.networks], axis=0)
    recipe = describe(series, chosen.options, fits, features) | {
        "method": "tuned",
        "restarts": ENSEMBLE,
        "seed": options.seed,
        "training_r2": r2(truth, mean),
        "cross_validated_r2": chosen.r2,
        "cross_validation": [_summary(choice) for choice in choices],
    }
    return replace(trained, recipe=recipe)


def steps() -> int:
    """How often `tune` reports progress."""
    return len(BANKS) + len(PENALTIES) - 1 + ENSEMBLE


def banks(options: Options) -> list[Options]:
    """Smoothing banks that are tried, at the first penalty."""
    return [replace(options, factor=a, count=n, l2=PENALTIES[0], sizes=SIZES) for a, n in BANKS]


def penalties(options: Options) -> list[Options]:
    """The other penalties, with everything else as it is."""
    return [replace(options, l2=l2) for l2 in PENALTIES[1:]]


def _best_of(
    candidates: Sequence[Options],
    tried: list[Choice],
    series: Sequence[Series],
    target: str,
    progress: Callable[[str], None],
) -> Choice:
    tried += [Choice(options, cross_validated(series, target, options, progress)) for options in candidates]
    return max(tried, key=lambda choice: choice.r2)


def cross_validated(
    series: Sequence[Series],
    target: str,
    options: Options,
    progress: Callable[[str], None] = lambda note: None,
) -> float:
    """r2 over `FOLDS` contiguous blocks, each predicted by a network that has not seen it.

    Errors are pooled before the quotient is taken, so that a quiet block does not decide.
    """
    blank = untrained(series, target, options)
    features, truth = training_arrays(blank, series)
    fold = np.arange(len(truth)) * FOLDS // len(truth)
    prediction = np.empty_like(truth)
    for held_out in range(FOLDS):
        rows = fold != held_out
        prediction[~rows] = _fit(features[rows], truth[rows], options, options.seed).network(features[~rows])
    score = r2(truth, prediction)
    progress(f"a = {options.factor:g}, N = {options.count}, L2 {options.l2:g}: cross-validated r2 {score:.4f}")
    return score


def _fit(features: FloatArray, truth: FloatArray, options: Options, seed: int) -> Fit:
    return engine(options.engine)(features, truth, options.sizes, seed, options.l2)


def _summary(choice: Choice) -> dict[str, float | int | list[int]]:
    options = choice.options
    return {
        "factor": options.factor,
        "count": options.count,
        "l2": options.l2,
        "sizes": list(options.sizes),
        "r2": choice.r2,
    }
