"""What is missing: every catalogue effect weighed, the best put in and judged on held-out data, and a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from testbench.discrepancy.baseline import SHAPES, starting_baseline, with_shapes, without_shapes
from testbench.discrepancy.confidence import with_intervals
from testbench.discrepancy.contest import FIT_RATE_HZ, Contest, challengers, reranked
from testbench.discrepancy.entrant import SHAPES_MUST_PAY, Bases, Entrant, bends
from testbench.discrepancy.errors import noise_floors
from testbench.discrepancy.evidence import (
    Evidence,
    Weighing,
    depending_on,
    ranked_with_costs,
    structure_left,
    weigh,
)
from testbench.discrepancy.fit import Fit, fit
from testbench.discrepancy.ladder import on_the_ladder
from testbench.discrepancy.measurement import FORCE_CHANNEL, Measurement, coarser, split
from testbench.discrepancy.model_file import ModelFile
from testbench.discrepancy.remains import remains
from testbench.discrepancy.remounting import held_errors
from testbench.discrepancy.runoff import run_off, unproven
from testbench.discrepancy.standin import stand_ins, with_stand_ins
from testbench.discrepancy.telling import Progress, silent
from testbench.discrepancy.traces import collect
from testbench.discrepancy.verdict import GAIN_TO_NAME, STRUCTURE_LEFT, Verdict, among_neighbours, verdict_of
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.knit.model import KnitModel
from testbench.recording import Recording

TIE_SHARE = 0.15  # of the first's gain; a tie is never wider than
TIE = 0.08  # ideas closer than this cannot be told apart
REFITS = 16
# ln(squared error) that the best elastic law may miss where nothing is missing. (The most of 66 sensors with nothing
# hidden, 48 of them from a simulator with laws of its own, was 0.03; the least of those with jamming 0.45.)
LAW_MAY_MISS = 0.3
WORKERS = 2
LATE_ENTRANTS = 2


@dataclass(frozen=True)
class Diagnosis:
    """Result of `diagnose`.

    Attributes
    ----------
    verdict : {"missing", "nothing_missing", "unknown"}
    weighing : Weighing
    tied : tuple of str
        Ideas that this pair of recordings cannot tell from the first; empty where the first stands alone.
    base_misfits : tuple of str
        Shapes that the base law needs: its own misfit, whatever else is missing.
    other_laws : tuple of str
        Laws that suit the sensor better than those of the base, and took their places.
    left : float
        Share of the held-out error above the noise floor that the best idea leaves.
    before, after : ModelFile
        The baseline, and with what was found put in and refitted.
    error_before, error_after, noise_floor : dict of channel to float
        Held-out RMS in N and in ln S.
    attempt : ModelFile, optional
        Where the verdict is `unknown`: with the first idea of the ranking put in all the same.
    """

    verdict: Verdict
    weighing: Weighing
    tied: tuple[str, ...]
    base_misfits: tuple[str, ...]
    other_laws: tuple[str, ...]
    left: float
    before: ModelFile
    after: ModelFile
    error_before: Mapping[str, float]
    error_after: Mapping[str, float]
    noise_floor: Mapping[str, float]
    attempt: ModelFile | None = None

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form; the shape is documented in docs/diagnosis.md."""
        return {
            "verdict": self.verdict,
            "ranking": [_ranked(entry, self.tied) for entry in self.weighing.ranking],
            "tied": list(self.tied),
            "base_misfits": list(self.base_misfits),
            "other_laws": list(self.other_laws),
            "depends_on": [
                {"channel": channel, "coordinate": coordinate, "gain": gain}
                for channel, coordinate, gain in self.weighing.depends_on
            ],
            "ceiling_gain": self.weighing.ceiling,
            "left_unexplained": self.left,
            "error_before": dict(self.error_before),
            "error_after": dict(self.error_after),
            "noise_floor": dict(self.noise_floor),
            "model_before": self.before.model.to_dict(),
            "model_after": self.after.model.to_dict(),
            "parameters_after": dict(self.after.fit),
            "history": [dict(step) for step in self.after.history],
        }


def _ranked(entry: Evidence, tied: tuple[str, ...]) -> dict[str, Any]:
    return {
        "effect": entry.idea,
        "form": entry.form,
        "gain": entry.gain,
        "gains": dict(entry.gains),
        "held_out_gain": list(entry.held_out) if entry.held_out else None,
        "error_share_left": float(np.exp(-0.5 * entry.gains["plain"])),
        "tied_for_first": entry.idea in tied,
        "seen_in_readings": entry.seen,
        "start": entry.candidate.at(entry.coefficient).model_dump(mode="json"),
    }


def diagnose(
    recording: Recording,
    held_out: Recording | None = None,
    model: KnitModel | None = None,
    catalogue: Catalogue | None = None,
    progress: Progress | None = None,
) -> Diagnosis:
    """Find out which physical effect a model is missing.

    Parameters
    ----------
    recording : Recording
        To calibrate on.
    held_out : Recording, optional
        To judge on; default the last third of `recording`.
    model : KnitModel, optional
        Start from this model instead of the baseline.
    catalogue : Catalogue, optional
        Effects to consider.
    progress : callable, optional
        Called with a short text at each step.

    Raises
    ------
    UserError
        If the recordings are too short or still, have a constant channel, or do not fit together.
    """
    tell = progress or silent
    catalogue = catalogue or load_catalogue()
    calibration, held = split(recording, held_out)
    tell("fitting the baseline")
    coarse = coarser(calibration, FIT_RATE_HZ)
    start = model or starting_baseline(calibration, catalogue)
    stiff = fit(without_shapes(start), [coarse])
    tell("fitting the shape of the base laws")
    bent = with_shapes(stiff.model, calibration, catalogue, like=start)
    flexible = fit(bent, [coarse], max_iterations=REFITS)
    weighing = weigh(collect(flexible, stiff.model, calibration, held, catalogue, tell))
    # What the user has is the model as given; where its laws bend already, so does what it is compared with.
    given = flexible if any(name in SHAPES for name in start) else stiff
    return _concluded(weighing, Bases(stiff, flexible), given, calibration, held, catalogue, tell)


def _concluded(
    weighing: Weighing,
    bases: Bases,
    given: Fit,
    calibration: Measurement,
    held: Measurement,
    catalogue: Catalogue,
    tell: Progress,
) -> Diagnosis:
    floors = noise_floors(held)
    before = on_the_ladder(given, None, "baseline", calibration, held)
    contest = Contest(bases, calibration, held, catalogue, tell)
    base = contest.base()
    weighing, entrants, law = _contested(contest, weighing, base)
    weighing = with_intervals(weighing, entrants, base.fit.model, held)
    best = entrants.get(weighing.ranking[0].idea) if weighing.ranking else None
    reached = best or base
    left = remains(base.held, reached.held, floors)
    before_usually, after_usually = (held_errors(one.fit.model, held, typical=True) for one in (base, reached))
    typical = remains(before_usually, after_usually, floors)
    verdict = verdict_of(weighing, left, typical)
    if verdict == "missing" and among_neighbours(weighing, left, typical):
        tell("looking for structure in what is left")
        verdict = "unknown" if structure_left(reached.fit, calibration, held) > STRUCTURE_LEFT else verdict
    law_misses = 2 * (law.score - base.score) if law else 0.0
    if verdict == "nothing_missing" and law_misses > LAW_MAY_MISS:
        # What bends it depends on strain alone: the free shape hides it from everything above.
        verdict, weighing = "unknown", depending_on(weighing, FORCE_CHANNEL, "strain", law_misses)
    named = best if verdict == "missing" else None
    bent = law if law and bends(base) and law.score < base.score + SHAPES_MUST_PAY else base
    after = _steps(named or bent, before, bases, calibration, held)
    attempt = _steps(best, before, bases, calibration, held) if best and verdict == "unknown" else None
    misfits, laws = _shapes_beyond(before, after.model), _laws_beyond(before, after.model)
    tied = _tied(weighing, verdict)
    first, last = (file.history[-1]["errors"]["held_out"] for file in (before, after))
    return Diagnosis(verdict, weighing, tied, misfits, laws, left.share, before, after, first, last, floors, attempt)


def _contested(
    contest: Contest, weighing: Weighing, base: Entrant
) -> tuple[Weighing, dict[str, Entrant], Entrant | None]:
    """The ranking with the refits taken in, the refitted ideas, and the base with an elastic law for its shape."""
    # The kernels let go of the interpreter, so threads do run side by side; those of BLAS would only fight them.
    with threadpool_limits(1, "blas"), ThreadPoolExecutor(WORKERS) as pool:
        return _refitted(contest, weighing, base, pool)


def _refitted(
    contest: Contest, weighing: Weighing, base: Entrant, pool: Executor
) -> tuple[Weighing, dict[str, Entrant], Entrant | None]:
    entering = {entry.idea: pool.submit(contest.enter, entry) for entry in challengers(weighing)}
    stood_in = stand_ins(contest, base, pool)
    instead = stood_in.found
    entrants = {idea: entrant.result() for idea, entrant in entering.items()}

    def judged() -> Weighing:
        refitted = reranked(weighing, base, list(entrants.values()))
        refitted = with_stand_ins(refitted, [evidence for _, evidence in instead.values()])
        return ranked_with_costs(refitted, contest.calibration.signals.keys())

    # Who comes close to the first when the others are refitted has to prove itself by a refit, too.
    for _ in range(LATE_ENTRANTS):
        late = unproven(judged(), {*entrants, *instead}, GAIN_TO_NAME)
        if late is None:
            break
        entrants[late.idea] = contest.enter(late)
    weighing = judged()
    entrants |= {idea: entrant for idea, (entrant, _) in instead.items()}
    return *run_off(contest, weighing, entrants, base, GAIN_TO_NAME, pool), stood_in.law


def _steps(
    winner: Entrant, before: ModelFile, bases: Bases, calibration: Measurement, held: Measurement
) -> ModelFile:
    """The ladder from the model as given to the winner's."""
    shapes = "shape freedom" if _shapes_beyond(before, winner.fit.model) else ""
    after = before
    if winner.name and shapes:
        after, shapes = on_the_ladder(bases.flexible, before, f"+ {shapes}", calibration, held), ""
    added = [name for name in (winner.name, shapes, *_laws_beyond(before, winner.fit.model)) if name]
    return on_the_ladder(winner.fit, after, f"+ {', '.join(added)}", calibration, held) if added else after


def _shapes_beyond(before: ModelFile, model: KnitModel) -> tuple[str, ...]:
    return tuple(name for name in model if name in SHAPES and name not in before.model)


def _laws_beyond(before: ModelFile, model: KnitModel) -> tuple[str, ...]:
    """Laws in the places of others."""
    same = [name for name in model if name in before.model]
    return tuple(model[name].name for name in same if model[name].name != before.model[name].name)


def _tied(weighing: Weighing, verdict: Verdict) -> tuple[str, ...]:
    if verdict != "missing":
        return ()
    first = weighing.ranking[0].gain
    close = [entry.idea for entry in weighing.ranking if entry.gain > first - min(TIE, TIE_SHARE * first)]
    return tuple(close) if len(close) > 1 else ()
