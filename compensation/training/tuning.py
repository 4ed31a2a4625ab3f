"""The tuned method: more memory, stronger L2, several networks; all chosen from the training recording alone.

Cross-validation predicts each half of the recording from the other, and each quarter from the rest: neighbouring
samples are alike, so folds of single samples would judge nothing, and a test is at least as far from the training as
its halves are from one another. One recording is a small sample all the same: which memories help is often left open.
The networks are then shared out among all that are within two standard errors of the best. What each part is for:
docs/compensation.md.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from compensation.engines.network import alive, mean_output
from compensation.memories.history import NO_HISTORY, History
from compensation.model.compensator import TrainedCompensator
from compensation.model.runtime import ready_for_use
from compensation.series.preprocessing import Series
from compensation.series.score import r2
from compensation.training.folds import contiguous
from compensation.training.lessons import Lessons, lessons
from compensation.training.options import Options
from compensation.training.untrained import describe, training_arrays, untrained
from gcode.support.arrays import FloatArray
from testbench.recordings.recording import recorded_duration_s

MOTION_TAUS_S, PLAY_RADII = (0.5, 2.0, 8.0, 32.0), (0.2, 0.5, 1.0)
HISTORIES = (NO_HISTORY, History((), PLAY_RADII), History(MOTION_TAUS_S), History(MOTION_TAUS_S, PLAY_RADII))
PENALTIES = (0.03, 0.1, 0.3, 1.0, 3.0)
# The first is taken where the others are not surely better.
BANKS = ((2.5, 7), (2.5, 8), (1.75, 10))
SIZES: tuple[tuple[int, ...], ...] = ((8,), (4,))
START_L2 = 0.1
# Standard errors by which one error must exceed another to count as larger.
SURE = 2.0
# Folds, and networks averaged in each.
FOLDS = ((2, 3), (4, 2))
ENSEMBLE = 8


@dataclass(frozen=True)
class Choice:
    """One combination and its cross-validated error, block by block (in variances of the target)."""

    options: Options
    errors: FloatArray
    r2: float


def tune(
    series: Sequence[Series], target: str, options: Options, progress: Callable[[str], None] = lambda note: None
) -> TrainedCompensator:
    """Choose by cross-validation (`choose`), then average several networks (`ensemble`).

    Parameters
    ----------
    series : sequence of Series
        Training recordings; nothing else is looked at.
    target : {"force", "displacement"}
    options : Options
        Seed and sampling; sizes, factors, history and penalty are replaced by the chosen ones. The engine does not
        matter: small batches of thinned-out rows are always used.
    progress : callable
        Told about each combination and each network: `steps` times.
    """
    options.check_for_use("--method tuned")
    members, tried = choose(series, target, options, progress)
    return ensemble(series, target, members, tried, options.seed, progress)


def choose(
    series: Sequence[Series], target: str, options: Options, progress: Callable[[str], None] = lambda note: None
) -> tuple[list[Choice], list[Choice]]:
    """Choose the bank, then histories and their penalties, then the size; seeds are fixed: the data decide.

    A choice for each kind of memory that is kept, the best first; and all that was tried.
    """
    tried: list[Choice] = []

    def judged(candidates: Sequence[Options]) -> list[Choice]:
        found = []
        for candidate in candidates:
            found.append(cross_validated(series, target, candidate))
            progress(_note(found[-1]))
        tried.extend(found)
        return found

    bank = first_unless_better(judged(banks(series, options))).options
    penalised = [[replace(bank, history=history, l2=l2) for l2 in PENALTIES] for history in HISTORIES]
    members = not_worse([_smallest(judged(candidates)) for candidates in penalised])
    others = judged([replace(members[0].options, sizes=size) for size in SIZES[1:]])
    sizes = first_unless_better([members[0], *others]).options.sizes
    return [replace(choice, options=replace(choice.options, sizes=sizes)) for choice in members], tried


def banks(series: Sequence[Series], options: Options) -> list[Options]:
    """The first choice and those whose slowest filter remembers no more than the longest recording."""
    longest_s = max(recorded_duration_s(part.time_s) for part in series)
    start = replace(options, sizes=SIZES[0], l2=START_L2, history=NO_HISTORY)
    first, *others = [replace(start, factor=a, count=n) for a, n in BANKS]
    return [first, *(other for other in others if other.slowest_s <= longest_s)]


def steps(series: Sequence[Series], options: Options) -> int:
    """How often `tune` reports progress."""
    return len(banks(series, options)) + len(HISTORIES) * len(PENALTIES) + len(SIZES) - 1 + ENSEMBLE


def first_unless_better(choices: Sequence[Choice]) -> Choice:
    """The first, or the best if that one is surely better."""
    best = _smallest(choices)
    return best if _excess(choices[0], best) > SURE else choices[0]


def not_worse(choices: Sequence[Choice]) -> tuple[Choice, ...]:
    """Those that are not surely worse than the best, which comes first."""
    best = _smallest(choices)
    return (best, *(choice for choice in choices if choice is not best and _excess(choice, best) <= SURE))


def _smallest(choices: Sequence[Choice]) -> Choice:
    return min(choices, key=lambda choice: float(choice.errors.mean()))


def _excess(choice: Choice, best: Choice) -> float:
    """How much larger its error is, in standard errors of the difference over blocks."""
    more = choice.errors - best.errors
    spread = float(more.std(ddof=1)) / np.sqrt(len(more))
    return float(more.mean()) / spread if spread > 0 else 0.0


def cross_validated(series: Sequence[Series], target: str, options: Options) -> Choice:
    """Predict contiguous blocks by networks that have not seen them, for every way of cutting in `FOLDS`."""
    learned = lessons(series, target, options)
    predictions = [_predicted(learned, options, folds, networks) for folds, networks in FOLDS]
    squares = np.mean([(learned.truth - prediction) ** 2 for prediction in predictions], axis=0)
    blocks = np.array_split(squares, max(len(squares) // learned.block_rows, 5))
    score = float(np.mean([r2(learned.truth, prediction) for prediction in predictions]))
    return Choice(options, np.array([block.mean() for block in blocks]), score)


def _predicted(learned: Lessons, options: Options, folds: int, networks: int) -> FloatArray:
    fold = contiguous(len(learned.truth), folds)
    prediction = np.empty_like(learned.truth)
    for held_out in range(folds):
        kept = fold != held_out
        fits = [learned.fit(kept, options, start) for start in range(networks)]
        prediction[~kept] = mean_output(fits, learned.versions[0][~kept])
    return prediction


def ensemble(
    series: Sequence[Series],
    target: str,
    members: Sequence[Choice],
    tried: Sequence[Choice],
    seed: int,
    progress: Callable[[str], None] = lambda note: None,
) -> TrainedCompensator:
    """The mean of `ENSEMBLE` networks from `seed` on, shared out among the choices kept."""
    best = members[0]
    whole = _union([choice.options.history for choice in members])
    lesson = [lessons(series, target, choice.options) for choice in members]
    blank = untrained(series, target, replace(best.options, history=whole))
    features, truth = training_arrays(blank, series)
    networks = []
    for number in range(ENSEMBLE):
        learned = lesson[number % len(lesson)]
        options = members[number % len(lesson)].options
        own = options.history
        known = [True, bool(own.motion_taus_s), bool(own.play_radii)]
        counts = [len(blank.alphas), len(whole.motion_taus_s), len(whole.play_radii)]
        networks.append(learned.fit_on_all(options, seed + number).reading(np.repeat(known, counts)))
        progress(f"network {seed + number}")
    live = alive(networks, features)
    recipe = describe(series, best.options, networks, features) | {
        "method": "tuned",
        "engine": "fast",
        "restarts": ENSEMBLE,
        "seed": seed,
        "training_r2": r2(truth, mean_output(live, features)),
        "cross_validated_r2": best.r2,
        "members": [_summary(choice) for choice in members],
        "cross_validation": [_summary(choice) for choice in tried],
    }
    return ready_for_use(replace(blank, networks=live, recipe=recipe), series)


def _union(histories: Sequence[History]) -> History:
    return History(
        max((history.motion_taus_s for history in histories), key=len),
        max((history.play_radii for history in histories), key=len),
        histories[0].settle_s,
    )


def _note(choice: Choice) -> str:
    options = choice.options
    return (
        f"a = {options.factor:g}, N = {options.count}, {_named(options.history)}, {options.sizes}, "
        f"L2 {options.l2:g}: cross-validated r2 {choice.r2:.4f}"
    )


def _named(history: History) -> str:
    parts = [name for name, used in (("motion", history.motion_taus_s), ("play", history.play_radii)) if used]
    return " and ".join(parts) or "no history"


def _summary(choice: Choice) -> dict[str, float | int | str | list[int]]:
    options = choice.options
    return {
        "factor": options.factor,
        "count": options.count,
        "history": _named(options.history),
        "l2": options.l2,
        "sizes": list(options.sizes),
        "r2": choice.r2,
    }
