"""Settling: an idea that was put in is given every freedom, so that its error is what it can reach."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

from testbench.discrepancy.baseline import with_shapes
from testbench.discrepancy.contest import REFIT_ITERATIONS, Contest
from testbench.discrepancy.entrant import SHAPES_MUST_PAY, Entrant, bends, has_events
from testbench.discrepancy.fit import fit
from testbench.discrepancy.noise import robust_sd
from testbench.discrepancy.remounting import placed
from testbench.discrepancy.screen import best_starts

ITERATIONS, TOUCH_UP_ITERATIONS = 30, 4
SEARCHES, SEARCH_MUST_PAY = 3, 0.02  # for events, each on what the last one left; in ln(RMS)
EVENTS_MAY_TRAIL = 0.5  # ln(RMS) behind the form that speaks for the idea, before they have settled


def settled(contest: Contest, entrant: Entrant) -> Entrant:
    """The entrant, or the same idea reached another way, whichever does better.

    A base that was free to bend before the idea came in has taken part of it over; here the idea settles on the
    stiff base first, and the shapes take what is left. Events settle beside the form that speaks for their idea:
    as long as some of them are missed, a smooth form does better.
    """
    others = [one for one in contest.entered.get(entrant.idea, ()) if one.name != entrant.name and has_events(one)]
    near = [one for one in others if one.score < entrant.score + EVENTS_MAY_TRAIL]
    ways = [entrant, *sorted(near, key=lambda one: one.score)[:1]]
    reached = [(_with_its_events if has_events(one) else _from_the_stiff_base)(contest, one) for one in ways]
    best = _with_the_unseen_absent(contest, min(reached, key=lambda one: one.score))
    return best if best.score < entrant.score - (0.0 if bends(entrant) else SHAPES_MUST_PAY) else entrant


def in_its_best_form(contest: Contest, entrant: Entrant, pool: Executor) -> Entrant:
    """The entrant, or another form of its idea in its place, where that comes nearer to the noise.

    Which form did best on a base that misfits for want of the effect says little about which it is.
    """
    others = [form for form in contest.forms_of(entrant.idea) if form.name != entrant.name]
    if not others or has_events(entrant) or contest.at_the_noise(entrant):
        return entrant
    contest.tell(f"trying other forms of {entrant.idea}")
    without = entrant.fit.model.without(entrant.name)
    starts = best_starts(without, others, contest.coarse)
    best = min(pool.map(partial(contest.refitted, without), starts), key=lambda one: one.score)
    if best.score > entrant.score - SEARCH_MUST_PAY:
        return entrant
    return min(best, _from_the_stiff_base(contest, best), key=lambda one: one.score)


def _from_the_stiff_base(contest: Contest, entrant: Entrant) -> Entrant:
    form = entrant.name
    effect = entrant.fit.model[form]
    contest.tell(f"settling {form}")
    first = entrant.fit if effect.imitable else fit(contest.bases.stiff.model.plus(effect), [contest.coarse])
    bent = with_shapes(first.model, contest.calibration, contest.catalogue)
    again = fit(bent, [contest.coarse], max_iterations=ITERATIONS)
    # Where ln G dives now and then, its dives would decide about everything: once more, with hardly a say.
    without_dives = fit(again.model, [contest.coarse], max_iterations=REFIT_ITERATIONS, scale_by=robust_sd)
    return min((contest.scored(form, one) for one in (again, without_dives)), key=lambda one: one.score)


def _with_its_events(contest: Contest, entrant: Entrant) -> Entrant:
    """Events looked for anew in what is left without them, as often as more of them are found."""
    for _ in range(SEARCHES):
        found = _from_the_stiff_base(contest, _placed_anew(contest, entrant))
        if found.score > entrant.score - SEARCH_MUST_PAY:
            return min(entrant, found, key=lambda one: one.score)
        entrant = found
    return entrant


def _placed_anew(contest: Contest, entrant: Entrant) -> Entrant:
    model = entrant.fit.model
    effect = placed(model[entrant.name], model.without(entrant.name), contest.calibration)
    return replace(entrant, fit=replace(entrant.fit, model=model.replacing(entrant.name, effect)))


def _with_the_unseen_absent(contest: Contest, entrant: Entrant) -> Entrant:
    """Without the parts of the effect's law that the calibration does not reach, where that does as well."""
    effect = entrant.fit.model[entrant.name]
    if not effect.absent_at:
        return entrant
    without = entrant.fit.model.replacing(entrant.name, effect.replaced(**effect.absent_at))
    other = contest.scored(entrant.name, fit(without, [contest.coarse], max_iterations=TOUCH_UP_ITERATIONS))
    return min(entrant, other, key=lambda one: one.score)
