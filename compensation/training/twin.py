"""The twin method: learn on campaigns simulated from the fitted knit model, and on the short measurement itself.

Two minutes of measurement do not tell every parameter of a model: networks that learn from several models, which
explain them about as well, learn what these have in common. The networks are of the tuned kind
(`compensation.training.lessons`), and the measurement is part of every lesson, repeated until it weighs `SHARE`:
finishing on it afterwards would teach the networks to forget the drift.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from compensation.engines.network import alive, mean_output
from compensation.memories.history import History
from compensation.model.compensator import TrainedCompensator
from compensation.model.runtime import ready_for_use
from compensation.series.preprocessing import Series, series_of
from compensation.series.score import r2
from compensation.training.lessons import lessons
from compensation.training.options import Options
from compensation.training.tuning import MOTION_TAUS_S, PLAY_RADII
from compensation.training.untrained import describe, training_arrays
from gcode.support.errors import UserError
from testbench.fitting.fit import Fit, fit
from testbench.knit.catalogue import load_catalogue
from testbench.knit.model import KnitModel
from testbench.measurements.coarser import coarser
from testbench.measurements.measurement import Measurement
from testbench.measurements.preparing import prepare
from testbench.recordings.recording import Recording

FIRST_SEED = 901
NETWORKS, SIZES, L2 = 8, (8,), 0.3
HISTORY = History(MOTION_TAUS_S, PLAY_RADII)
# Of the lessons, as much as the measurement makes up.
SHARE = 0.3
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
DRAWS, OTHERS = 6, 2


def simulated(
    models: Sequence[KnitModel], target: str, gauge_length_mm: float, amplitude: float, rate_hz: float
) -> list[Series]:
    """One campaign of each model: the paper's trajectory, from a new seed each, scaled to `amplitude` strain.

    The first samples rest where the trajectory begins, so the model starts unloaded, as a measurement does.

    Raises
    ------
    UserError
        If a model makes no conductance, or no force where that is the target.
    """
    from gcode.mach4.controller import play
    from gcode.mach4.reader import read_program
    from gcode.programs.make import make
    from gcode.trajectories.presets import preset
    from testbench.knit.model import inputs

    found = []
    for seed, model in enumerate(models, start=FIRST_SEED):
        played = play(read_program(make(preset("paper-1"), seed, gauge_length_mm).program), rate_hz=rate_hz)
        travel_mm = played.position_mm - played.position_mm.min()
        strain = amplitude * travel_mm / travel_mm.max()
        signals = model.simulate(inputs(played.time_s, strain), 1.0 / rate_hz)
        for name in ("conductance_S", *(("force_N",) if target == "force" else ())):
            if name not in signals:
                raise UserError(f"the twin's model makes no {name}; fit one on a recording that has it")
        truth = signals["force_N"] if target == "force" else strain * gauge_length_mm
        found.append(Series(played.time_s, signals["conductance_S"], truth, f"twin, seed {seed}"))
    return found


def train_from_twin(
    model: KnitModel,
    recording: Recording,
    target: str,
    amplitude: float,
    options: Options | None = None,
    progress: Callable[[str], None] = lambda note: None,
) -> TrainedCompensator:
    """Find out what the twin may be from a short measurement, then learn from both.

    Parameters
    ----------
    model : KnitModel
        Start of the fit: the baseline as `testbench fit` leaves it, or a model with what a diagnosis has found.
    recording : Recording
        The short measurement.
    target : {"force", "displacement"}
    amplitude : float
        Largest strain of the campaigns to come.
    options : Options, optional
        Seed and sampling; sizes, history and penalty are the twin's own.
    progress : callable
        Told `steps` times: of the fit and each network.
    """
    options = replace(options or Options(), sizes=SIZES, l2=L2, history=HISTORY)
    options.check_for_use("--twin")
    measured = series_of(recording, target, options.resampling_hz)
    models = plausible(model, recording)
    progress("fitted the model")
    twins = simulated(models, target, recording.gauge_length_mm, amplitude, options.rate_hz)
    compensator = learned(twins, measured, target, options, progress)
    effects = list(models[0].effects)
    return replace(compensator, recipe=dict(compensator.recipe) | {"twin_effects": effects})


def steps() -> int:
    """How often `train_from_twin` reports progress."""
    return 1 + NETWORKS


def learned(
    twins: Sequence[Series],
    measured: Series,
    target: str,
    options: Options,
    progress: Callable[[str], None] = lambda note: None,
    share: float = SHARE,
) -> TrainedCompensator:
    """Networks that learn from campaigns and from a measurement that makes up `share` of the rows."""
    campaign_rows = sum(len(part) for part in twins)
    copies = max(round(share / (1.0 - share) * campaign_rows / len(measured)), 1) if share else 0
    series = [*twins, *[measured] * copies]
    learning = lessons(series, target, options)
    networks = []
    for seed in range(options.seed, options.seed + NETWORKS):
        networks.append(learning.fit_on_all(options, seed))
        progress(f"network {seed}")
    features, truth = training_arrays(learning.blank, [measured])
    live = alive(networks, features)
    recipe = describe([measured], options, networks, features) | {
        "method": "twin",
        "engine": "fast",
        "restarts": NETWORKS,
        "seed": options.seed,
        "twin_campaigns": [part.source for part in twins],
        "training_r2": r2(truth, mean_output(live, features)),
    }
    return ready_for_use(replace(learning.blank, networks=live, recipe=recipe), series)


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
    """Models that explain a short measurement: one fitted `with_memories`, then the best of a few draws about it."""
    measurement = coarser(prepare(recording), FIT_RATE_HZ)
    best = fit(with_memories(model), measurement)
    # The posterior is a Gaussian only near its top: of the draws, those that still explain the measurement are kept.
    others = sorted(draws(best, DRAWS, seed=0), key=lambda one: _misfit(one, measurement, best))
    return (best.model, *others[:OTHERS])


def draws(best: Fit, count: int, seed: int) -> list[KnitModel]:
    """Models drawn from the fit's posterior, within the bounds."""
    rng = np.random.default_rng(seed)
    values, vectors = np.linalg.eigh(best.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    moved = (best.vector + root @ rng.standard_normal(len(best.vector)) for _ in range(count))
    return [best.parameters.model_at(best.model, vector) for vector in moved]


def _misfit(model: KnitModel, measurement: Measurement, best: Fit) -> float:
    """Mean square residual in units of the best fit's; infinite where the model gives no numbers."""
    residuals = measurement.residual(model).items()
    total = float(sum(np.mean((own[measurement.counts] / best.scale[name]) ** 2) for name, own in residuals))
    return total if np.isfinite(total) else np.inf
