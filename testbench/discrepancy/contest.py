"""The contest: the ideas that screened best are put in, refitted in full, and judged on both recordings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from testbench.discrepancy.baseline import framed
from testbench.discrepancy.candidates import candidate_ideas, is_vector
from testbench.discrepancy.contact_start import contact_start
from testbench.discrepancy.entrant import SHAPES_MUST_PAY, Bases, Entrant, bends, spoken_for_by
from testbench.discrepancy.errors import noise_floors, over_the_floors, rms_errors
from testbench.discrepancy.evidence import Evidence, Weighing
from testbench.discrepancy.fit import Fit, fit
from testbench.discrepancy.measurement import CONDUCTANCE_CHANNEL, Measurement, coarser
from testbench.discrepancy.remounting import held_errors, placed
from testbench.discrepancy.screen import STIFF, best_starts
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect, Stage
from testbench.knit.model import KnitModel

ENTRANTS = 3
WORTH_A_REFIT = 0.4  # of the best gain
AS_GOOD = 0.8  # of the best gain: one more is refitted
LEAST_GAIN = 0.02
REFIT_ITERATIONS, ALONE_ITERATIONS = 10, 20
FIT_RATE_HZ = 12.5  # grid of the fits; errors are judged on the samples as recorded
NEARLY_AT_THE_NOISE = 1.3  # mean error over the noise floors
UNDECIDED = 0.05  # share of strain in what the contacts feel, off either end


class Contest:
    """Refits entrants on the calibration recording and scores them on both."""

    def __init__(
        self,
        bases: Bases,
        calibration: Measurement,
        held: Measurement,
        catalogue: Catalogue,
        tell: Callable[[str], None],
    ) -> None:
        self.bases, self.calibration, self.held = bases, calibration, held
        self.coarse = coarser(calibration, FIT_RATE_HZ)
        self.catalogue, self.tell = catalogue, tell
        self.entered: dict[str, list[Entrant]] = {}  # every form that was refitted, by idea
        self._floors = noise_floors(held)
        self._ideas = candidate_ideas(catalogue, bases.stiff.model)
        self._signals = frozenset(bases.stiff.model.simulate(self.coarse.signals, self.coarse.dt_s))

    def base(self) -> Entrant:
        """The base alone: flexible where that pays, stiff elsewhere."""
        stiff, flexible = (self.scored("", one) for one in (self.bases.stiff, self.bases.flexible))
        return flexible if flexible.score < stiff.score - SHAPES_MUST_PAY else stiff

    def enter(self, entry: Evidence) -> Entrant:
        """Put an idea in and refit; the base bends freely, or not at all where that was best.

        Several forms may speak for the idea: the one that screened best, the one that fits best on the stiff base,
        where all parameters of a form can be moved but nothing else can do its work, and those made of events.
        """
        self.tell(f"putting in {entry.idea} and refitting")
        effects = {entry.form: entry.candidate.at(entry.coefficient)}
        alone = self.alone(self.forms_of(entry.idea))
        if alone:
            best = min(alone, key=lambda one: one.score)
            effects[best.name] = best.fit.model[best.name]
        effects |= {effect.name: effect for effect in self.events_of(entry.idea)}
        bases = [self.bases.flexible.model] + ([self.bases.stiff.model] if entry.mode == STIFF else [])
        entrants = [self.refitted(model, effect) for model in bases for effect in effects.values()]
        self.entered[entry.idea] = entrants
        return min(entrants, key=lambda one: one.score + (SHAPES_MUST_PAY if bends(one) else 0.0))

    def refitted(self, model: KnitModel, effect: Effect) -> Entrant:
        """`model` with the effect put in."""
        return self.scored(effect.name, fit(model.plus(effect), [self.coarse], max_iterations=REFIT_ITERATIONS))

    def forms_of(self, idea: str) -> list[Effect]:
        """Forms of an idea that a search on the stiff base can start from."""
        return self._started(self._ideas.get(idea, ()))

    def imitable_forms(self) -> list[Effect]:
        """Those of all ideas that a shape of the base could imitate."""
        return self._started(form for forms in self._ideas.values() for form in forms if form.imitated_by)

    def _started(self, forms: Iterable[type[Effect]]) -> list[Effect]:
        usable = [f for f in forms if not is_vector(f, f.strength) and self._signals.issuperset(f.reads)]
        return [framed(form(), self.bases.stiff.model, self.coarse) for form in usable]

    def events_of(self, idea: str) -> list[Effect]:
        """Forms of an idea that consist of events, placed where the misfit has them.

        That of the stiff base shows them best: what bent to follow the past of events has wiggles between them.
        """
        usable = [form for form in self._ideas.get(idea, ()) if self._signals.issuperset(form.reads)]
        forms = [form for form in usable if is_vector(form, form.strength)]
        if not forms:
            return []
        for model in (self.bases.stiff.model, self.bases.flexible.model):
            starts = [framed(form(), model, self.calibration) for form in forms]
            effects = [placed(start, model, self.calibration) for start in starts]
            found = [effect for start, effect in zip(starts, effects, strict=True) if effect != start]
            if found:
                return found
        return []

    def seen_effects(self) -> list[Effect]:
        """Forms that the readings themselves show."""
        model, here = self.bases.stiff.model, self.calibration
        state, residual = model.simulate(here.signals, here.dt_s), here.residual(model)
        forms = [f for forms in self._ideas.values() for f in forms if self._signals.issuperset(f.reads)]
        found = [form().seen(state, residual, here.dt_s) for form in forms]
        return [effect for effect in found if effect is not None]

    def alone(self, effects: Sequence[Effect], each: Callable[..., Iterable[Entrant]] = map) -> list[Entrant]:
        """Each effect fitted on the stiff base; `each` maps, side by side where it can."""
        stiff = self.bases.stiff.model
        starts = best_starts(stiff, effects, self.coarse) if effects else []
        return list(each(self._alone, starts))

    def _alone(self, effect: Effect) -> Entrant:
        models = [self.bases.stiff.model.plus(effect)]
        if effect.stage is Stage.PRESSURE and "contact" in models[0]:
            models += [self._with_new_contact(one) for one in [models[0], *_driven_otherwise(models[0])]]
        fits = [fit(model, [self.coarse], max_iterations=ALONE_ITERATIONS) for model in models]
        return min((self.scored(effect.name, one) for one in fits), key=lambda one: one.score)

    def _with_new_contact(self, model: KnitModel) -> KnitModel:
        """The model with its contact law started anew: fitted before the effect came in, it has bent to its work."""
        here = self.coarse
        pressing = model.simulate(here.signals, here.dt_s)["contact_force_N"]
        log_g = here.measured[CONDUCTANCE_CHANNEL]
        return model.replacing("contact", contact_start(model["contact"], pressing, log_g))

    def at_the_noise(self, entrant: Entrant) -> bool:
        """Whether a better form could hardly do better."""
        return over_the_floors(entrant.held, self._floors) < NEARLY_AT_THE_NOISE

    def scored(self, name: str, result: Fit) -> Entrant:
        """A fit with its errors on both recordings."""
        held = held_errors(result.model, self.held)
        both = [rms_errors(result.model, self.calibration), held]
        score = float(np.mean([np.log(value) for errors in both for value in errors.values()]))
        idea = result.model[name].idea or name if name else ""
        return Entrant(name, idea, result, score, held)


def _driven_otherwise(model: KnitModel) -> list[KnitModel]:
    """With contacts that feel the force alone, or the strain alone, where the base found a bit of both.

    Without the effect a bit of both may be the next best thing: what fades in the contacts does so in one of the two.
    """
    if "contact_drive" not in model:
        return []
    drive = model["contact_drive"]
    if not UNDECIDED < drive.model_dump()["strain_share"] < 1 - UNDECIDED:
        return []
    return [model.replacing("contact_drive", drive.near(strain_share=end)) for end in (0.0, 1.0)]


def challengers(weighing: Weighing) -> list[Evidence]:
    """The ideas worth a refit: the best, and those that come near."""
    ranking = [entry for entry in weighing.ranking if not entry.candidate.effect.imitable]
    least = max(LEAST_GAIN, WORTH_A_REFIT * ranking[0].gain) if ranking else 0.0
    near = [entry for entry in ranking[ENTRANTS : ENTRANTS + 1] if entry.gain >= AS_GOOD * ranking[0].gain]
    return [entry for entry in [*ranking[:ENTRANTS], *near] if entry.gain >= least]


def reranked(weighing: Weighing, base: Entrant, entrants: Sequence[Entrant]) -> Weighing:
    """The ranking with the refits taken in: half the screening's gain, half the refit's."""
    refitted = {entrant.idea: entrant for entrant in entrants}
    first = [_taken_in(e, refitted[e.idea], base) for e in weighing.ranking if e.idea in refitted]
    rest = [entry for entry in weighing.ranking if entry.idea not in refitted]
    return replace(weighing, ranking=(*first, *rest))


def _taken_in(entry: Evidence, entrant: Entrant, base: Entrant) -> Evidence:
    """The evidence with the refit's gain, and the form that did best."""
    return replace(spoken_for_by(entry, entrant), gain=0.5 * entry.gain + (base.score - entrant.score))
