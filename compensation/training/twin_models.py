"""What a twin may be: the given model with the memories it lacks, fitted to the measurement, and its near kin.

Two minutes do not tell every parameter. A network that has seen several models that explain the measurement about
equally well learns what they have in common.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from testbench.fitting.fit import Fit, fit
from testbench.knit.catalogue import load_catalogue
from testbench.knit.model import KnitModel
from testbench.measurements.coarser import coarser
from testbench.measurements.measurement import Measurement
from testbench.measurements.preparing import prepare
from testbench.recordings.recording import Recording

# Effects that remember, weak at first: a fit makes of them what the measurement asks for. In the order of the chain.
MEMORIES: dict[str, dict[str, Any]] = {
    "permanent_set_recovering": {"fraction": 0.02},
    "stress_relaxation": {"fraction": 0.05},
    "contact_relaxation": {"fraction": 0.05},
    "contact_hysteresis": {"friction_N": 0.02},
    "electrical_overshoot": {"gain": 0.05},
    "electrical_overshoot_magnitude": {"gain": 0.05},
}
FIT_RATE_HZ = 10.0
DRAWS, KIN = 6, 2


def with_memories(model: KnitModel) -> KnitModel:
    """The model with every effect of `MEMORIES` that it lacks and whose signals it has."""
    effects = load_catalogue().effects
    known = {"strain"}.union(*(effect.reads + effect.writes for effect in model.effects.values()))
    present = {effect.mechanism for effect in model.effects.values()}
    for name, start in MEMORIES.items():
        memory = effects[name](**start)
        if memory.mechanism not in present and known.issuperset(memory.reads + memory.writes):
            model = model.plus(memory)
    return model


def plausible(model: KnitModel, recording: Recording) -> tuple[KnitModel, ...]:
    """Models that explain a short measurement: the fitted one first, then the best of a few draws about it.

    Parameters
    ----------
    model : KnitModel
        Start of the fit; `with_memories` is applied to it.
    recording : Recording

    Returns
    -------
    tuple of KnitModel
        ``1 + KIN`` of them.
    """
    measurement = coarser(prepare(recording), FIT_RATE_HZ)
    best = fit(with_memories(model), measurement)
    # The posterior is a Gaussian only near its top: of the draws, those that still explain the measurement are kept.
    kin = sorted(draws(best, DRAWS, seed=0), key=lambda one: _misfit(one, measurement, best))
    return (best.model, *kin[:KIN])


def draws(best: Fit, count: int, seed: int) -> list[KnitModel]:
    """Models drawn from the fit's posterior, within the bounds."""
    rng = np.random.default_rng(seed)
    values, vectors = np.linalg.eigh(best.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    moved = (best.vector + root @ rng.standard_normal(len(best.vector)) for _ in range(count))
    return [best.parameters.model_at(best.model, vector) for vector in moved]


def _misfit(model: KnitModel, measurement: Measurement, best: Fit) -> float:
    """Mean square residual in units of the best fit's; infinite where the model gives no numbers."""
    residuals: Sequence = list(measurement.residual(model).items())
    squares = [np.mean((values[measurement.counts] / best.scale[channel]) ** 2) for channel, values in residuals]
    total = float(np.sum(squares))
    return total if np.isfinite(total) else np.inf
