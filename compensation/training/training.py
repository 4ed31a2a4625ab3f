"""Training a compensator on one or more recordings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from compensation.engines.engine import engine
from compensation.engines.network import Network
from compensation.model.compensator import TrainedCompensator
from compensation.model.runtime import ready_for_use
from compensation.series.preprocessing import Series, series_of
from compensation.series.score import r2
from compensation.training.options import Options
from compensation.training.tuning import tune
from compensation.training.untrained import describe, training_arrays, untrained
from testbench.recordings.recording import Recording

MORE_STARTS = 6


def train(
    recordings: Sequence[Recording],
    target: str,
    options: Options | None = None,
    progress: Callable[[str], None] = lambda note: None,
    tuned: bool = False,
) -> TrainedCompensator:
    """Train a compensator; scalers and networks see these recordings only.

    Parameters
    ----------
    recordings : sequence of Recording
        Each starts with a fresh smoothing bank: no history leaks over a boundary.
    target : {"force", "displacement"}
    options : Options, optional
    progress : callable
        Told about each network that is done.
    tuned : bool
        Choose factors, penalty and size from the data, average several networks: see `compensation.training.tuning`.
    """
    options = options or Options()
    series = [series_of(recording, target, options.resampling_hz) for recording in recordings]
    return (tune if tuned else train_on_series)(series, target, options, progress)


def train_on_series(
    series: Sequence[Series],
    target: str,
    options: Options,
    progress: Callable[[str], None] = lambda note: None,
) -> TrainedCompensator:
    """As `train`, on prepared series."""
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
        networks.append(engine(options.engine)(features, truth, options.sizes, seed, options.l2).network)
        scores.append(r2(truth, networks[-1](features)))
        progress(f"seed {seed}: training r2 {scores[-1]:.4f}")
    best = int(np.argmax(scores))
    recipe = describe(series, options, networks, features) | {
        "seed": options.seed + best,
        "training_r2": scores[best],
    }
    return ready_for_use(replace(blank, networks=(networks[best],), recipe=recipe), series)
