"""From what the best model leaves to a law on the ladder, as far as it holds on the held-out recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import takewhile

import numpy as np
from threadpoolctl import threadpool_limits

from testbench.comparing.ladder import on_the_ladder
from testbench.comparing.model_errors import noise_floors, over_the_floors
from testbench.diagnosis.searching.search import Progress, Search
from testbench.fitting.baseline import SHAPES
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.fit import Fit
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.splitting import split
from testbench.proposing.blindness import not_judged
from testbench.proposing.grids import Grid
from testbench.proposing.hunt import Hunt
from testbench.proposing.laws.law import Law
from testbench.proposing.laws.places import PLACES
from testbench.proposing.laws_found import Proposed, Step, Verdict, numbered
from testbench.proposing.open_chain import OpenChain
from testbench.proposing.trial import as_fitted
from testbench.proposing.writing import effect_class
from testbench.recordings.between import FRESH
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile

MOST_LAWS = 2


def propose_law(
    recording: Recording,
    held_out: Recording | None = None,
    model: ModelFile | None = None,
    name: str = "my_effect",
    catalogue: Catalogue | None = None,
    progress: Progress | None = None,
    most: int = MOST_LAWS,
) -> Proposed:
    """Find the law that is missing from a model, whatever the catalogue knows.

    Parameters
    ----------
    recording : Recording
        To calibrate on; everything is chosen on it.
    held_out : Recording, optional
        For the final error, and to take back a law that does not hold; default the last third of `recording`.
    model : ModelFile, optional
        The best model so far; its base laws are made free to bend. Default: the baseline.
    name : str
        Of the effect.
    catalogue : Catalogue, optional
        Where the laws of the base come from.
    progress : callable, optional
        Called with a short text at each step.
    most : int
        Laws at most.

    Raises
    ------
    UserError
        If the recordings are too short or too still, have a constant channel, or do not fit together.
    """
    tell = progress or (lambda text: None)
    between = model.between if model and held_out else FRESH
    calibration, held = split(recording, held_out, between=between)
    with threadpool_limits(1, "blas"):
        search = Search(calibration, catalogue or load_catalogue(), tell, model.model if model else None)
        hunt = Hunt(search, name, model is not None)
        found = hunt.run(most)
        tell("judging on the held-out recording")
        return _judged(hunt, found, model, calibration, held)


def _judged(
    hunt: Hunt,
    found: Sequence[tuple[Step, Hypothesis]],
    file: ModelFile | None,
    calibration: Measurement,
    held: Measurement,
) -> Proposed:
    """The laws put on the ladder one after the other, as far as each holds on the held-out recording."""
    given = any(name in SHAPES for name in (file.model if file else ()))
    ladder = before = file or on_the_ladder(Fit.of(hunt.search.baseline), None, "baseline", calibration, held)
    bases = [("refitted" if given else "+ shape freedom", hunt.search.flexible)]
    bases += [("+ other base laws", hunt.base)] if hunt.base is not hunt.search.flexible else []
    floors = noise_floors(held)
    for step_name, base in bases:
        ladder = on_the_ladder(Fit.of(base), ladder, step_name, calibration, held)
        # A base that foretells less than the one before is no yardstick: laws beside it must do better than both.
        before = ladder if holds(_held(before), _held(ladder), floors) else before
    after = before
    rejected: Step | None = None
    kept: list[Step] = []
    for index, (step, h) in enumerate(found):
        law = at_its_instrument(step.option.law)
        step = replace(
            step, option=replace(step.option, law=law), beyond=beyond_the_fit(law, h.model, calibration, held)
        )
        tried = on_the_ladder(
            Fit.of(with_class(h, law, numbered(hunt.name, index), hunt.grid)),
            ladder, f"+ {numbered(hunt.name, index)}", calibration, held,
        )  # fmt: skip
        if not holds(_held(after), _held(tried), floors):
            rejected = step
            break
        after = ladder = tried
        kept.append(step)
    # A law that came later has moved the numbers of those before it.
    for index, step in enumerate(kept):
        law = as_fitted(step.option.law, after.model[numbered(hunt.name, index)])
        kept[index] = replace(step, option=replace(step.option, law=law))
    verdict: Verdict = "proposed" if kept else "does_not_hold" if rejected else "no_law"
    if hunt.said_nothing_left:
        verdict = "nothing_left"
    return Proposed(
        verdict, hunt.name, tuple(kept), rejected, tuple(not_judged(calibration)), before, after,
        _held(before), _held(after), floors, calibration, held, hunt.grid,
    )  # fmt: skip


def with_class(h: Hypothesis, law: Law, name: str, grid: Grid) -> Hypothesis:
    """The hypothesis with the law as the file will hold it."""
    effect = effect_class(law, name, grid)()
    model = KnitModel({k: e for k, e in h.model.effects.items() if k != name}).plus(effect, name)
    return replace(h, model=model)


def holds(before: Mapping[str, float], after: Mapping[str, float], floors: Mapping[str, float]) -> bool:
    """Whether a law foretells the held-out recording better than the model without it.

    The error, the mean of the channels in noise floors, must fall, and so must the sum of their logarithms: the
    likelihood of noise whose size is not known. What one channel gains pays for what another loses by the refit, as
    far as it is the same factor.
    """
    factors = [after[c] / before[c] for c in floors]
    return over_the_floors(after, floors) < over_the_floors(before, floors) and float(np.prod(factors)) < 1.0


def beyond_the_fit(law: Law, model: KnitModel, calibration: Measurement, held: Measurement) -> float:
    """Share of the held-out samples at which what a law follows lies beyond all that it was fitted on.

    That is z before its factors: what multiplies it does not say how far a state or a memory has gone.
    """
    pieces = tuple(takewhile(lambda one: one.kind != "factor", law.term.operators))
    followed = replace(law.term, operators=pieces)
    seen, new = (
        followed.evaluated(OpenChain(model, m).readable(law.place), law.values, m.dt_s)[m.counts]
        for m in (calibration, held)
    )
    return float(np.mean((new < seen.min()) | (new > seen.max())))


def at_its_instrument(law: Law) -> Law:
    """A law of the conductance that depends on readings alone, at once or by a dead band, is one of the meter."""
    readings = {"conductance", "force", "force rate"}
    at_once = law.term.memory in ("", "late", "echo", "clock", "dead band")
    if law.place.name == "conductance" and law.term.coordinate.name in readings and at_once:
        return replace(law, place=PLACES["conductance reading"])
    return law


def _held(file: ModelFile) -> Mapping[str, float]:
    return file.history[-1]["errors"]["held_out"]
