"""The automatic method: several methods, weighted by how well each predicts what it has not seen.

The parts, from the simplest on:

- *line*: a straight line through the conductance.
- *ridge*: linear in the smoothing bank, motion and play operators, learned from shifted copies as well.
- *paper*: the paper's bank and (4, 2, 2), the best of five starts by training score.
- *networks*: several small networks on bank, motion and play with strong L2; memories and L2 chosen within.
- *stack*: the last three, each with a weight (stacked regression; Breiman, Machine Learning 24 (1996) 49).

Each predicts every fold (`compensation.training.folds`) from the others and makes all its own choices there, scalers
and ranges among them; at the pace of the recording, and as if it had been slower or quicker. The stack's own figures
are of weights that were found without the fold. Of methods that one recording cannot tell apart, a pick would be
chance; the weights share the risk of another motion or another day. Why, and what it brings: docs/compensation.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compensation.model.compensator import Scaling, TrainedCompensator
from compensation.model.runtime import ready_for_use
from compensation.series import score
from compensation.series.preprocessing import Series, stands_still
from compensation.training.folds import fold_count, folds_of, split
from compensation.training.intervals import of_another, of_one_recording
from compensation.training.learners import PACES, Learner, Line, Networks, Paper, Ridge
from compensation.training.options import Options
from compensation.training.recalibration import one_sigma_changes
from compensation.training.untrained import describe
from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from testbench.recordings.recording import recorded_duration_s

LEARNERS: tuple[type[Learner], ...] = (Line, Ridge, Paper, Networks)
STACK, STACKED = "stack", tuple(kind.name for kind in (Ridge, Paper, Networks))


def train_automatically(
    series: Sequence[Series], target: str, options: Options, progress: Callable[[str], None] = lambda note: None
) -> TrainedCompensator:
    """Choose by cross-validation, train the chosen on everything.

    Parameters
    ----------
    series : sequence of Series
        Training recordings; nothing else is looked at.
    target : {"force", "displacement"}
    options : Options
        Seed and sampling; everything else is chosen.
    progress : callable
        Told about each fold of each method: `steps` times.

    Returns
    -------
    TrainedCompensator
        Its recipe says what was tried, what was taken and what cross-validation promises of it.
    """
    options.check_for_use("--method auto")
    folds, whole = folds_of(series)
    _check_moves(series, target, folds)
    truth = np.concatenate([part.truth for part in series])
    scaling = Scaling.of(truth)
    truth, scale = scaling.apply(truth), scaling.scale
    held_out = cross_validated(series, target, options, folds, progress)
    at_all_paces = {name: scaling.apply(values) for name, values in held_out.items()}
    predictions = {name: values[0] for name, values in at_all_paces.items()}
    predictions[STACK] = stacked(at_all_paces, truth, folds)
    chosen = choose(predictions, truth)
    weights = weights_of(at_all_paces, truth) if chosen == STACK else {chosen: 1.0}
    compensator = _trained(weights, learners_on(series, target, options), series, options)
    progress(f"trained {chosen} on everything")
    tried = {name: figures(truth, values, scale) for name, values in predictions.items()}
    residual = (truth - predictions[chosen]) * scale
    changes = None if whole else one_sigma_changes(compensator, series)
    promise: dict[str, Any] = tried[chosen] | {
        "r2_interval": _interval(truth, predictions[chosen], series, whole),
        "raw_r2": _raw_r2(series, compensator.sign),
        "line_r2": tried[Line.name]["r2"],
        "folds": fold_count(folds),
        "whole_recordings": whole,
    }
    if changes is not None:
        promise["r2_elsewhere"] = r2_elsewhere(residual, changes, scale)
    found = {"chosen": chosen, "weights": weights, "tried": tried, "cross_validated": promise}
    margins = margins_of(residual, folds, [len(part) for part in series], changes)
    return replace(compensator, recipe=dict(compensator.recipe) | found, margins=margins)


def _check_moves(series: Sequence[Series], target: str, folds: NDArray[np.int64]) -> None:
    """Refuse recordings of which nothing can be learned where one fold is held out: the others stand still."""
    for number in range(fold_count(folds)):
        rest, _ = split(series, folds == number)
        for name, values in (("conductance", [p.conductance_S for p in rest]), (target, [p.truth for p in rest])):
            if stands_still(np.concatenate(values)):
                raise UserError(
                    f"{series[0].source}: without one of {fold_count(folds)} parts the {name} stands still, so "
                    "nothing can be cross-validated; give recordings that move throughout, or take --method tuned"
                )


def steps(series: Sequence[Series]) -> int:
    """How often `train_automatically` reports progress on these series."""
    return fold_count(folds_of(series)[0]) * len(LEARNERS) + 1


def margins_of(
    residual: FloatArray, folds: NDArray[np.int64], lengths: Sequence[int], changes: FloatArray | None
) -> tuple[float, float]:
    """Ends of the interval for an error to come; `changes` are None where whole recordings were held out."""
    if changes is None:
        return of_another(np.split(residual, np.cumsum(lengths)[:-1]))
    parts = [folds == number for number in np.unique(folds)]
    return of_one_recording([residual[rows] for rows in parts], [changes[:, rows] for rows in parts])


def r2_elsewhere(residual: FloatArray, changes: FloatArray, scale: float) -> float:
    """Ordinary r2 to be expected where gains and zeros are off as on another day or specimen.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Errors of cross-validation, in the target's unit.
    changes : ndarray, shape (k, n)
        Of `one_sigma_changes`; the numbers behind them are independent, so their squares add up.
    scale : float
        Standard deviation of the target.
    """
    return float(1.0 - (np.mean(residual**2) + np.mean(changes**2, axis=1).sum()) / scale**2)


def figures(truth: FloatArray, prediction: FloatArray, scale: float) -> dict[str, float]:
    """The paper's r2, the ordinary one, and the RMS error in units."""
    return {
        "r2": score.r2(truth, prediction),
        "r2_ordinary": score.r2_ordinary(truth, prediction),
        "rms_error": float(np.sqrt(np.mean((truth - prediction) ** 2))) * scale,
    }


def learners_on(series: Sequence[Series], target: str, options: Options) -> dict[str, Learner]:
    """Every method on these recordings, not fitted yet."""
    learners: dict[str, Learner] = {}
    for kind in LEARNERS:
        learners[kind.name] = kind(series, target, options, like=next(reversed(learners.values()), None))
    return learners


def cross_validated(
    series: Sequence[Series],
    target: str,
    options: Options,
    folds: NDArray[np.int64],
    progress: Callable[[str], None] = lambda note: None,
) -> dict[str, FloatArray]:
    """What each method predicts of each fold, having seen nothing of it, not even for its scalers: (paces, n)."""
    found = {kind.name: np.empty((len(PACES), len(folds))) for kind in LEARNERS}
    for number in range(fold_count(folds)):
        rest, parts = split(series, folds == number)
        for name, learner in learners_on(rest, target, options).items():
            found[name][:, folds == number] = learner.predict(learner.fit(), parts)
            progress(f"{name}, fold {number + 1}")
    return found


def choose(predictions: Mapping[str, FloatArray], truth: FloatArray) -> str:
    """The stack where it predicts better than the line, by however little; else the line.

    The stack has learned from copies at other levels and paces, the line from the recording as it is: where one
    recording cannot tell the two apart, another one mostly can.
    """
    line, stack = (np.mean((truth - predictions[name]) ** 2) for name in (Line.name, STACK))
    return STACK if stack < line else Line.name


def weights_of(predictions: Mapping[str, FloatArray], truth: FloatArray) -> dict[str, float]:
    """The weights of the stack's parts that fit best, none negative, together 1; a part without weight is left out.

    With weights that sum to 1 the error of the stack is the weighted sum of the parts' errors. The sum s of weights
    that minimise ``|errors w|^2 + (1 - sum w)^2`` alone depends on the size of that error, not how they share it out:
    at shares v the best s leaves ``q / (1 + q)``, which rises with ``q = |errors v|^2``.

    Parameters
    ----------
    predictions : mapping of ndarray, each shape (paces, n)
    truth : ndarray, shape (n,)
    """
    from scipy.optimize import nnls

    errors = np.column_stack([(predictions[name] - truth).ravel() for name in STACKED])
    ones = np.full(len(STACKED), max(float(np.linalg.norm(errors)), 1e-12))
    found, _ = nnls(np.vstack([errors, ones]), np.append(np.zeros(len(errors)), ones[0]))
    return {name: float(w) for name, w in zip(STACKED, found / found.sum(), strict=True) if w > 0}


def stacked(predictions: Mapping[str, FloatArray], truth: FloatArray, folds: NDArray[np.int64]) -> FloatArray:
    """What the stack predicts of each fold at the pace of the recording, with weights from the other folds."""
    result = np.empty(len(truth))
    for number in np.unique(folds):
        here = folds == number
        weights = weights_of({name: predictions[name][:, ~here] for name in STACKED}, truth[~here])
        result[here] = sum(weight * predictions[name][0, here] for name, weight in weights.items())
    return result


def _trained(
    weights: Mapping[str, float], learners: Mapping[str, Learner], series: Sequence[Series], options: Options
) -> TrainedCompensator:
    """The weighted parts, fitted on everything, as networks whose mean is the answer."""
    last = learners[list(weights)[-1]]
    lesson, parts = last.lessons, {name: learners[name].fit() for name in weights}
    count = sum(len(part.networks) for part in parts.values())
    networks = [
        network.times(count * weights[name] / len(part.networks)).absorbing(lesson.shift, lesson.scale)
        for name, part in parts.items()
        for network in part.networks
    ]
    learned = parts[last.name]
    restarts = learned.settings.get("restarts", 1)
    recipe = describe(series, replace(last.options, l2=learned.settings["l2"]), (), last.features) | {
        "method": "auto",
        "engine": "fast",
        "seed": options.seed,
        "restarts": restarts,
        "dead_networks": restarts - len(learned.networks) if last.name == Networks.name else 0,
        "settings": dict(learned.settings),
    }
    return ready_for_use(replace(lesson.blank, networks=tuple(networks), recipe=recipe), series)


def _raw_r2(series: Sequence[Series], sign: float) -> float:
    """Mean r2 of the raw signal over the recordings whose target moves; of a rest there is no r2."""
    moving = [part for part in series if not stands_still(part.truth)]
    return float(np.mean([score.r2_before(part.truth, part.conductance_S, sign) for part in moving]))


def _interval(truth: FloatArray, prediction: FloatArray, series: Sequence[Series], whole: bool) -> list[float] | None:
    """95 % of r2: `score.jackknife_interval` over whole recordings where they are held out, else over blocks."""
    if not whole:
        step_s = sum(recorded_duration_s(part.time_s) for part in series) / len(truth)
        return score.block_interval(truth, prediction, np.arange(len(truth)) * step_s)
    owner = np.repeat(np.arange(len(series)), [len(part) for part in series])
    without = [score.r2(truth[owner != number], prediction[owner != number]) for number in range(len(series))]
    return score.jackknife_interval(score.r2(truth, prediction), without)
