"""Effects that a freely bending base law could imitate: do they do as well as its free shape, with fewer numbers?

A clipped reading, jammed loops or lost motion depend on the present strain, force or direction alone, and so do the
shapes of the base laws: with both in, neither gains. So the effect goes in *instead* of the shape that could imitate
it. Where it then explains the recordings as well as dozens of free numbers do, it is the better explanation. (It also
goes in beside the shape: a corner that no smooth shape can follow shows there.)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from testbench.discrepancy.baseline import LOOP_SHAPES, with_shapes, without_shapes
from testbench.discrepancy.contest import Contest
from testbench.discrepancy.elastic_laws import ELASTICITY, Drawn, DrawnLaws, bends_the_law, draw_laws
from testbench.discrepancy.entrant import Entrant
from testbench.discrepancy.evidence import PRICE_OF_SHAPE, Evidence, Weighing
from testbench.discrepancy.fit import fit
from testbench.discrepancy.measurement import FORCE_CHANNEL
from testbench.discrepancy.screen import FLEXIBLE, WITHOUT_SLIP
from testbench.knit.effect import Effect, Stage
from testbench.knit.model import KnitModel

WITHOUT_ELASTICITY, WITHOUT_CONTACT = "without elasticity_shape", "without contact_shape"
WITHOUT = {"elasticity": WITHOUT_ELASTICITY, "contact": WITHOUT_CONTACT, "slip": WITHOUT_SLIP}
# What a mode forbids: whole shapes, and parts of contact_shape. Slip of the contacts stays where it is their law over
# force and strain that must not bend: no effect that bends the law could do its work.
REMOVED = {WITHOUT_ELASTICITY: ("elasticity_shape",), WITHOUT_SLIP: LOOP_SHAPES}
ZEROED = {WITHOUT_CONTACT: ("force_weights", "strain_weights"), WITHOUT_SLIP: ("slip_weights", "slip_growth")}
WORTH_A_TRY = 0.05  # ln(squared error) that an effect must gain on the stiff base
FINALISTS, FORMS_OF_ONE_IDEA = 4, 2
WORTH_A_DOUBT = 0.05
SEEN_GAIN = 0.15  # at least, of what the readings themselves show
OTHER_LOOPS = 0.25  # ln(squared error) that Bouc-Wen loops buy
OTHER_KIND = 0.1  # share of the gain that counts where the loops are of another kind
# Share of what a free shape buys that an effect instead of it is credited with. (That of the contacts buys less than
# 0.01 where nothing is hidden, and 0.4 to 1.6 where they saturate.)
PRICES = {WITHOUT_ELASTICITY: PRICE_OF_SHAPE, WITHOUT_CONTACT: 0.2, WITHOUT_SLIP: PRICE_OF_SHAPE}
# The same of what the best elastic law of a few numbers misses. (Less than 0.02 of a sensor with another elastic law
# and nothing hidden, 0.2 where that law is not in the catalogue, 0.45 to 1.7 with jamming.)
PRICE_OF_LAW = 0.3
BENT_ITERATIONS, BESIDE_ITERATIONS = 14, 10


@dataclass(frozen=True)
class _Tried:
    """An imitable effect in place of the shape that could imitate it, and beside it (not if beside another law)."""

    mode: str
    instead: Entrant
    beside: Entrant | None


@dataclass(frozen=True)
class StandIns:
    """What was tried in place of the shapes of the base.

    Attributes
    ----------
    found : dict of idea to (Entrant, Evidence)
        The best of the imitable effects, with the gain over the base at a fair price: see `_gain`.
    law : Entrant, optional
        Not an effect, but the elastic law that does best in place of its free shape.
    """

    found: Mapping[str, tuple[Entrant, Evidence]]
    law: Entrant | None


def stand_ins(contest: Contest, base: Entrant, pool: Executor) -> StandIns:
    """The best of the imitable effects, refitted in place of the shapes that could imitate them.

    Parameters
    ----------
    contest : Contest
    base : Entrant
        What the gains are counted from.
    pool : Executor
        Where the refits run, side by side.
    """
    laws, forms = _drawn_laws(contest, contest.imitable_forms())
    tried = list(pool.map(partial(_tried, contest), _finalists(_alone(contest, forms, pool))))
    compared = {one.mode for one in tried} | ({FLEXIBLE} if tried else set())
    if laws:
        compared.add(WITHOUT_ELASTICITY)
        if laws.beside and laws.tell_apart:
            tried.append(_beside_another_law(contest, laws.beside))
    modes = sorted(compared)
    bare = dict(zip(modes, pool.map(partial(_bare, contest, laws), modes), strict=True))
    other_loops = cache(lambda: _has_other_loops(contest, base))
    found: dict[str, tuple[Entrant, Evidence]] = {}
    for one in tried:
        best, gain = _judged(one, base, bare, other_loops)
        if best.idea not in found or gain > found[best.idea][1].gain:
            found[best.idea] = best, _evidence(best, one.mode, gain)
    return StandIns(found | _seen(contest, base), bare[WITHOUT_ELASTICITY] if laws else None)


def _judged(
    one: _Tried, base: Entrant, bare: Mapping[str, Entrant], other_loops: Callable[[], bool]
) -> tuple[Entrant, float]:
    """The better of the effect in place of the shape and beside it, and what it gains."""
    gain = _gain(one, base, bare[one.mode])
    if one.beside is None:
        return one.instead, gain
    # Neither a converter nor the contacts have to do with the kind of the loops.
    mechanical = one.instead.fit.model[one.instead.name].stage < Stage.PRESSURE
    if gain > WORTH_A_DOUBT and mechanical and other_loops():
        gain *= OTHER_KIND
    # Against a base that was given as many steps more: a fit that goes on gets better without any effect.
    gain = max(gain, 2 * (min(base.score, bare[FLEXIBLE].score) - one.beside.score))
    return min(one.instead, one.beside, key=lambda entrant: entrant.score), gain


def _tried(contest: Contest, entrant: Entrant) -> _Tried:
    mode = WITHOUT[entrant.fit.model[entrant.name].imitated_by]
    contest.tell(f"putting in {entrant.name} for the shape that could imitate it")
    start = with_shapes(entrant.fit.model, contest.calibration, contest.catalogue)
    instead = min(entrant, _refitted(contest, entrant.name, start, mode), key=lambda one: one.score)
    bent = with_shapes(instead.fit.model, contest.calibration, contest.catalogue)
    return _Tried(mode, instead, _refitted(contest, entrant.name, bent, FLEXIBLE))


def _drawn_laws(contest: Contest, forms: Sequence[Effect]) -> tuple[DrawnLaws | None, list[Effect]]:
    """Elastic laws of a few numbers, and the forms that they say nothing of; None and all without a force."""
    model = contest.bases.flexible.model
    if FORCE_CHANNEL not in contest.calibration.measured or ELASTICITY not in model:
        return None, list(forms)
    bending = {form.name: form for form in forms if bends_the_law(form)}
    laws = draw_laws(model, contest.calibration, contest.catalogue, list(bending.values()))
    return laws, [form for form in forms if form.name not in bending]


def _beside_another_law(contest: Contest, drawn: Drawn) -> _Tried:
    assert drawn.effect is not None
    contest.tell(f"putting in {drawn.effect.name} beside {drawn.law.name}")
    instead = _refitted(contest, drawn.effect.name, drawn.put_in(contest.bases.flexible.model), WITHOUT_ELASTICITY)
    return _Tried(WITHOUT_ELASTICITY, instead, None)


def _bare(contest: Contest, laws: DrawnLaws | None, mode: str) -> Entrant:
    """The base without what `mode` forbids; without a free shape of the elastic law, with the law that does best."""
    models = [contest.bases.flexible.model]
    if laws and mode == WITHOUT_ELASTICITY:
        models = [laws.alone.put_in(models[0]), *(models if laws.tell_apart else ())]
    return min((_refitted(contest, "", model, mode) for model in models), key=lambda one: one.score)


def _seen(contest: Contest, base: Entrant) -> dict[str, tuple[Entrant, Evidence]]:
    """Effects that the readings show: however well the base's shapes imitate them, they are there."""
    found = {}
    for effect in contest.seen_effects():
        contest.tell(f"putting in {effect.name}, which the readings show")
        unbent = with_shapes(contest.bases.stiff.model.plus(effect), contest.calibration, contest.catalogue)
        starts = [contest.bases.flexible.model.plus(effect), unbent]
        best = min((_refitted(contest, effect.name, one, FLEXIBLE) for one in starts), key=lambda one: one.score)
        gain = max(2 * (base.score - best.score), SEEN_GAIN)
        found[best.idea] = best, replace(_evidence(best, FLEXIBLE, gain), seen=True)
    return found


def _refitted(contest: Contest, name: str, model: KnitModel, mode: str) -> Entrant:
    iterations = BESIDE_ITERATIONS if mode == FLEXIBLE else BENT_ITERATIONS
    bent = straightened(model, mode)
    result = fit(bent, [contest.coarse], max_iterations=iterations, addresses=may_move(mode))
    return contest.scored(name, result)


def straightened(model: KnitModel, mode: str) -> KnitModel:
    """`model` without the shapes that `mode` forbids."""
    model = without_shapes(model, REMOVED.get(mode, ()))
    if mode in ZEROED and "contact_shape" in model:
        contact = model["contact_shape"]
        none = {key: (0.0,) * len(getattr(contact, key)) for key in ZEROED[mode]}
        model = model.replacing("contact_shape", contact.replaced(**none))
    return model


def may_move(mode: str) -> Callable[[str], bool]:
    """Whether a parameter, by its address, is free under `mode`."""
    held = tuple(f"contact_shape.{key}[" for key in ZEROED.get(mode, ()))
    return lambda address: not address.startswith(held)


def _finalists(alone: Sequence[Entrant]) -> list[Entrant]:
    """The best few, and not only forms of one idea."""
    chosen: list[Entrant] = []
    for entrant in alone:
        if sum(one.idea == entrant.idea for one in chosen) < FORMS_OF_ONE_IDEA:
            chosen.append(entrant)
    return chosen[:FINALISTS]


def _alone(contest: Contest, forms: Sequence[Effect], pool: Executor) -> list[Entrant]:
    """Each of the forms on the stiff base, best first; only those that gain at all."""
    before = contest.scored("", contest.bases.stiff)
    found = contest.alone(forms, pool.map)
    worth = [one for one in found if 2 * (before.score - one.score) > WORTH_A_TRY]
    return sorted(worth, key=lambda one: one.score)


def _gain(one: _Tried, base: Entrant, bare: Entrant) -> float:
    """ln(squared error of the base at the price of its shape / squared error with the effect instead).

    The price is a share of what the shape buys: the errors of the base without it (`bare`) over those with it.
    """
    bought = max(2 * (bare.score - base.score), 0.0)
    shortfall = 2 * (one.instead.score - base.score)
    if one.beside is None:  # another law may suit the sensor better by itself: that is not to the effect's credit
        return float(np.log1p(PRICE_OF_LAW * np.expm1(bought))) - max(shortfall, 0.0)
    return float(np.log1p(PRICES[one.mode] * np.expm1(bought))) - shortfall


def _has_other_loops(contest: Contest, base: Entrant) -> bool:
    """Whether the loops are of another kind than the base's: Bouc-Wen instead of slip elements.

    Then so is the elastic law, most likely: it bends of itself, and not because of an effect.
    """
    slip_only = without_shapes(contest.bases.flexible.model, ("hysteresis_bouc_wen",))
    without = contest.scored("", fit(slip_only, [contest.coarse], max_iterations=BENT_ITERATIONS))
    return 2 * (without.score - base.score) > OTHER_LOOPS


def _evidence(entrant: Entrant, mode: str, gain: float) -> Evidence:
    return Evidence(entrant.idea, entrant.name, gain, {"white": gain, "plain": gain}, mode, entrant.candidate, 1.0)


def with_stand_ins(weighing: Weighing, found: Sequence[Evidence]) -> Weighing:
    """The ranking with imitable ideas judged by their refits; those that were not worth one stand last."""
    judged = {evidence.idea: evidence for evidence in found}
    rest = [
        replace(entry, gain=min(entry.gain, 0.0)) if entry.candidate.effect.imitable else entry
        for entry in weighing.ranking
        if entry.idea not in judged
    ]
    return replace(weighing, ranking=(*rest, *judged.values()))
