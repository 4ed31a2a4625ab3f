"""Training a compensator on one or more recordings, by one of the methods."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from compensation.engines.engine import ENGINES
from compensation.engines.network import Network
from compensation.model.compensator import TrainedCompensator
from compensation.model.runtime import ready_for_use
from compensation.series.preprocessing import Series
from compensation.series.score import r2
from compensation.training import auto, tuning
from compensation.training.options import Options
from compensation.training.untrained import describe, training_arrays, untrained

MORE_STARTS = 6


def train_on_series(
    series: Sequence[Series], target: str, options: Options, progress: Callable[[str], None] = lambda note: None
) -> TrainedCompensator:
    """The paper's method: one bank and one network, the best of several starts by training score."""
    blank = untrained(series, target, options)
    features, truth = training_arrays(blank, series)
    networks: list[Network] = []
    # One start is the publication's, dead or not; where several are asked for, one that lives is looked for.
    tries = options.restarts if options.restarts < 2 else MORE_STARTS * options.restarts
    scores: list[float] = []
    while len(networks) < options.restarts or (
        len(networks) < tries and all(network.is_dead(features) for network in networks)
    ):
        seed = options.seed + len(networks)
        networks.append(ENGINES[options.engine](features, truth, options.sizes, seed, options.l2).network)
        scores.append(r2(truth, networks[-1](features)))
        progress(f"seed {seed}: training r2 {scores[-1]:.4f}")
    best = int(np.argmax(scores))
    recipe = describe(series, options, networks, features) | {
        "seed": options.seed + best,
        "training_r2": scores[best],
    }
    return ready_for_use(replace(blank, networks=(networks[best],), recipe=recipe), series)


# By the names that `compensation train --method` and `compensation.Compensator` know.
METHODS = {"auto": auto.train_automatically, "paper": train_on_series, "tuned": tuning.tune}


def steps(method: str, series: Sequence[Series], options: Options) -> int:
    """How often a method reports progress on these series; the paper's more often where all starts are dead."""
    return {"auto": auto.steps(series), "paper": options.restarts, "tuned": tuning.steps(series, options)}[method]
