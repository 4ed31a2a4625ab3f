"""The run-off: ideas that came close to the first are settled in full, and their refits decide.

Screening is to first order and on a base that has taken part of the effect over; where two ideas come close, that is
worth less than how near the noise each of them gets once everything may move.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

import numpy as np

from testbench.discrepancy.contest import Contest
from testbench.discrepancy.entrant import Entrant, spoken_for_by
from testbench.discrepancy.evidence import Evidence, Weighing, ranked, share_after_costs
from testbench.discrepancy.settling import in_its_best_form, settled

CLOSE = 0.25  # of the first's gain
AKIN = 0.5  # of the first's gain: comes close if it is akin to it
MOST = 3
SHARE_OF_REFIT = 0.95


def run_off(
    contest: Contest,
    weighing: Weighing,
    entrants: Mapping[str, Entrant],
    base: Entrant,
    least_gain: float,
    pool: Executor,
) -> tuple[Weighing, dict[str, Entrant]]:
    """Settle the first idea and those that come close, and rank again.

    Parameters
    ----------
    weighing : Weighing
        Ranked, costs paid.
    entrants : mapping of idea to Entrant
    base : Entrant
        What the gains are counted from.
    least_gain : float
        Ideas below it are not worth settling.
    pool : Executor
        Where they settle, side by side.
    """
    close = [entry.idea for entry in _close(weighing, entrants, least_gain)]
    in_full = dict(zip(close, pool.map(partial(settled, contest), [entrants[idea] for idea in close]), strict=True))
    spoken_for = [spoken_for_by(e, in_full[e.idea]) if e.idea in in_full else e for e in weighing.ranking]
    weighing = replace(weighing, ranking=tuple(spoken_for))
    if len(in_full) > 1:
        measured = contest.calibration.signals.keys()
        decided = [_decided(e, in_full[e.idea], base, measured) for e in weighing.ranking if e.idea in in_full]
        # Who was not close enough to be settled is still judged to first order; that does not overtake a winner.
        most = (1 - CLOSE) * max(entry.gain for entry in decided)
        others = [replace(e, gain=min(e.gain, most)) for e in weighing.ranking if e.idea not in in_full]
        weighing = ranked(weighing, [*decided, *others])
    entrants = {**entrants, **in_full}
    return _first_in_its_best_form(contest, weighing, entrants, base, pool) if close else (weighing, entrants)


def _first_in_its_best_form(
    contest: Contest, weighing: Weighing, entrants: dict[str, Entrant], base: Entrant, pool: Executor
) -> tuple[Weighing, dict[str, Entrant]]:
    first, *others = weighing.ranking
    entrant = in_its_best_form(contest, entrants[first.idea], pool)
    if entrant is entrants[first.idea]:
        return weighing, entrants
    again = _decided(spoken_for_by(first, entrant), entrant, base, contest.calibration.signals.keys())
    again = replace(again, gain=max(again.gain, first.gain))
    return ranked(weighing, [again, *others]), {**entrants, first.idea: entrant}


def unproven(weighing: Weighing, refitted: Collection[str], least_gain: float) -> Evidence | None:
    """The best idea that comes close to the first, is akin to it, or is it, without having been refitted."""
    if not weighing.ranking or weighing.ranking[0].gain < least_gain:
        return None
    first = weighing.ranking[0]
    for entry in weighing.ranking:
        near = entry.gain >= max(least_gain, (1 - CLOSE) * first.gain) or entry.idea in first.candidate.effect.akin
        if near and entry.idea not in refitted and not entry.candidate.effect.imitable:
            return entry
    return None


def _close(weighing: Weighing, entrants: Mapping[str, Entrant], least_gain: float) -> list[Evidence]:
    """The first, and those whose gain can be compared with it; imitable ideas have paid another kind of price."""
    ranking = [entry for entry in weighing.ranking if entry.idea in entrants and entry.gain > least_gain]
    if not ranking or ranking[0].idea != weighing.ranking[0].idea:
        return []
    first, *others = ranking
    if first.candidate.effect.imitable:
        return [first]
    akin = first.candidate.effect.akin
    near = [e for e in others if e.gain > (AKIN if e.idea in akin else 1 - CLOSE) * first.gain]
    return [first, *(e for e in near if not e.candidate.effect.imitable)][:MOST]


def _decided(entry: Evidence, entrant: Entrant, base: Entrant, measured: Collection[str]) -> Evidence:
    screened = float(np.mean(list(entry.gains.values())))
    refitted = 2 * (base.score - entrant.score)
    gain = SHARE_OF_REFIT * refitted + (1 - SHARE_OF_REFIT) * screened
    return replace(entry, gain=share_after_costs(entry, measured) * gain)
