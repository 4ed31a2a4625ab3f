"""What a search comes to: what was found is put in, and judged on what was held out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from testbench.comparing.ladder import as_a_step, on_the_ladder
from testbench.comparing.model_errors import noise_floors
from testbench.diagnosis.held_out import block_energies, gain_interval
from testbench.diagnosis.judging.discrepancy_map import mapped
from testbench.diagnosis.judging.entries import Entry, Proposal
from testbench.diagnosis.judging.probabilities import NOTHING, UNKNOWN, mixed_with_prior, prior_of
from testbench.diagnosis.judging.put_in import leading, whole_of
from testbench.diagnosis.judging.rounds import Round, Verdict
from testbench.diagnosis.result import Diagnosis, Found, Ranked
from testbench.diagnosis.searching.search import Search
from testbench.fitting import constants
from testbench.fitting.baseline import SHAPES
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.fit import Fit
from testbench.knit.effect import FloatArray
from testbench.measurements.measurement import Measurement
from testbench.results.model_file import ModelFile

VISIBLE = 0.01  # share of the residual's squares; on what explains less, what is left does not depend
TIED = 0.9  # the smallest set of mechanisms with this probability is what cannot be told apart


def concluded(
    search: Search,
    rounds: Sequence[Round],
    put_in: Sequence[Entry],
    calibration: Measurement,
    held: Measurement,
    given: ModelFile | None = None,
) -> Diagnosis:
    """What a search comes to: the verdict, its probabilities, and a ladder with the errors held out.

    Parameters
    ----------
    search, rounds, put_in
        As `search.searched` returns them.
    calibration, held : Measurement
    given : ModelFile, optional
        The user's fitted model, from which the search started.
    """
    before = _before(given, search, calibration, held)
    first, bare = rounds[0], rounds[0].before.hypothesis
    verdict = first.verdict(whole_of(rounds, put_in))
    if verdict != "missing":
        put_in = []
    left = first.left(*put_in, everywhere=True) if put_in else 1.0
    lead = leading(put_in)
    most, beside = rounds[lead], whole_of(rounds[lead:], put_in[lead:])
    after = _ladder(search, bare, put_in, before, calibration, held)
    other_laws = search.other_laws(before.model, after.model)
    known = {*before.model, *other_laws, *(entry.name for entry in put_in)}
    weighed = dict.fromkeys(name for step in rounds[: lead + 1] for name in step.laws)
    meant = most.probabilities(beside)
    chances = mixed_with_prior(meant, prior_of(weighed), constants.MISLED)
    explained = mapped(put_in[-1].hypothesis if put_in else bare, rounds[-1].likelihood).gains
    leading_first = sorted(range(len(put_in)), key=lambda k: k != lead)
    depends_on = ((channel, where, share) for (channel, where), share in explained.items() if share >= VISIBLE)
    return Diagnosis(
        verdict=verdict,
        probabilities=chances,
        found=tuple(_found(rounds[k:], put_in[k:]) for k in leading_first),
        ranking=_ranking(rounds[: lead + 1], chances, held),
        tied=_tied(meant, verdict),
        base_misfits=tuple(name for name in after.model if name not in known),
        other_laws=tuple(other_laws.values()),
        bends_like=first.bend.mechanism if first.bend and verdict == "nothing_missing" else "",
        depends_on=tuple(sorted(depends_on, key=lambda one: -one[2])),
        left=left,
        before=before,
        after=after,
        error_before=before.history[-1]["errors"]["held_out"],
        error_after=after.history[-1]["errors"]["held_out"],
        noise_floor=noise_floors(held),
    )


def _before(given: ModelFile | None, search: Search, calibration: Measurement, held: Measurement) -> ModelFile:
    """The first step of the ladder: a model that was fitted is not fitted anew, so that it keeps its errors."""
    if given is None:
        return on_the_ladder(_as_used(search.baseline), None, "baseline", calibration, held)
    return as_a_step(given.model, given.fit, None, "baseline", calibration, held)


def _found(rounds: Sequence[Round], put_in: Sequence[Entry]) -> Found:
    """The first of the effects that were put in, of which each round has one."""
    step, entry = rounds[0], put_in[0]
    chance = step.doubted(whole_of(rounds, put_in))[entry.mechanism]
    return Found(entry.mechanism, entry.law, chance, step.added(entry))


def _ladder(
    search: Search,
    bare: Hypothesis,
    put_in: Sequence[Entry],
    before: ModelFile,
    calibration: Measurement,
    held: Measurement,
) -> ModelFile:
    """From the baseline over the freedom of its shapes to each effect that was found."""
    steps = [(f"+ {entry.law}", entry.hypothesis) for entry in put_in]
    if not any(name in SHAPES for name in before.model):
        steps.insert(0, ("+ shape freedom", bare))
    after = before
    for (name, _), last in zip(steps, search.sharp([h for _, h in steps]), strict=True):
        after = on_the_ladder(_as_used(last), after, name, calibration, held)
    return after


def _as_used(h: Hypothesis) -> Fit:
    """The fit of a hypothesis, less the shapes that the evidence has switched off."""
    return Fit.of(h, h.model_in_use)


def _ranking(rounds: Sequence[Round], chances: Mapping[str, float], held: Measurement) -> tuple[Ranked, ...]:
    """Every mechanism by its best law in the last of these rounds, the most probable first.

    An effect that was put in before stands as it did in the round that found it.
    """
    found: dict[str, Ranked] = {}
    for step in reversed(rounds):
        bare = block_energies(step.before.hypothesis.model, held)
        every: list[Entry | Proposal] = [*step.entries, *step.proposals]
        for own in every:
            if own.mechanism not in found:
                found[own.mechanism] = _ranked(own, step, chances[own.mechanism], bare, held)
    return tuple(sorted(found.values(), key=lambda one: (-one.probability, -one.log_evidence)))


def _ranked(
    own: Entry | Proposal, step: Round, chance: float, bare: Mapping[str, FloatArray], held: Measurement
) -> Ranked:
    """One mechanism in one round; `bare` has the squared errors without it, block by block."""
    named = partial(Ranked, effect=own.mechanism, law=own.law, probability=chance)
    if isinstance(own, Proposal):
        gain = 2 * max(own.gain, 0.0) / (step.likelihood.count * len(step.likelihood.floor))
        left = float(np.exp(-0.5 * gain))
        return named(log_evidence=own.gain, gain=gain, left=left, held_out_gain=None, start=own.effect)
    h, base = own.hypothesis, step.before.hypothesis
    return named(
        log_evidence=step.added(own),
        gain=float(np.mean([2 * np.log(base.evidence.sigma[c] / s) for c, s in h.evidence.sigma.items()])),
        left=step.left(own, everywhere=True),
        held_out_gain=gain_interval(bare, block_energies(h.model, held)),
        start=h.model[own.name],
    )


def _tied(chances: Mapping[str, float], verdict: Verdict) -> tuple[str, ...]:
    if verdict != "missing":
        return ()
    ordered = sorted((name for name in chances if name not in (NOTHING, UNKNOWN)), key=lambda name: -chances[name])
    total, chosen = 0.0, []
    for name in ordered:
        chosen.append(name)
        total += chances[name]
        if total >= TIED * sum(chances[other] for other in ordered):
            break
    return tuple(chosen) if len(chosen) > 1 else ()
