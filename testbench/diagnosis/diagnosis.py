"""What is missing: every law of the catalogue weighed by its evidence, and what was found put in and judged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcode.support.errors import UserError
from testbench.comparing.ladder import as_a_step, on_the_ladder
from testbench.comparing.model_errors import noise_floors
from testbench.diagnosis.discrepancy_map import mapped
from testbench.diagnosis.entries import Entry
from testbench.diagnosis.held_out import Interval, block_energies, gain_interval
from testbench.diagnosis.probabilities import NOTHING, UNKNOWN, mixed_with_prior, prior_of
from testbench.diagnosis.proposals import Proposal
from testbench.diagnosis.put_in import leading, whole_of
from testbench.diagnosis.rounds import Round, Verdict
from testbench.diagnosis.search import Progress, Search, searched
from testbench.fitting import constants
from testbench.fitting.baseline import SHAPES
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.fit import Fit
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.knit.effect import Effect, FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.joining import joined, last_of
from testbench.measurements.measurement import Measurement, split
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile

REST_S, MOST_REST_S = 60.0, 86_400.0  # between several recordings of one specimen: usual, and at most
TIED = 0.9  # the smallest set of mechanisms with this probability is what cannot be told apart


@dataclass(frozen=True)
class Ranked:
    """One mechanism's case.

    Attributes
    ----------
    effect, law : str
        The mechanism, and the law of the catalogue that speaks for it.
    probability : float
        That it is what is missing most.
    log_evidence : float
        ln Z over the model without it, in nats.
    gain : float
        ln(squared error without / with it) on the calibration, channels averaged; to first order if not refitted.
    left : float
        Share of the calibration error above the noise that it leaves alone, all channels together.
    held_out_gain : (value, low, high), optional
        As `gain`, on held-out samples with its 95 % interval; None where it was not refitted.
    start : Effect
        The law with its parameters.
    """

    effect: str
    law: str
    probability: float
    log_evidence: float
    gain: float
    left: float
    held_out_gain: Interval | None
    start: Effect

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form."""
        return {
            "effect": self.effect,
            "law": self.law,
            "probability": self.probability,
            "log_evidence": self.log_evidence,
            "gain": self.gain,
            "held_out_gain": list(self.held_out_gain) if self.held_out_gain else None,
            "error_share_left": self.left,
            "start": self.start.model_dump(mode="json"),
        }


@dataclass(frozen=True)
class Found:
    """An effect that was put in.

    Attributes
    ----------
    effect, law : str
        Mechanism and law.
    probability : float
        Of this mechanism among all that could have been put in at this step.
    log_evidence : float
        What it added, in nats.
    """

    effect: str
    law: str
    probability: float
    log_evidence: float


@dataclass(frozen=True)
class Diagnosis:
    """Result of `diagnose`.

    Attributes
    ----------
    verdict : {"missing", "nothing_missing", "unknown"}
    probabilities : mapping
        Of ``nothing``, ``unknown`` and every mechanism: what is missing most. They sum to 1.
    found : tuple of Found
        The effects that were put in, in turn, but the one that the model misses most without it first.
    ranking : tuple of Ranked
        Every mechanism, the most probable first.
    tied : tuple of str
        The mechanisms that share 90 % of the probability; empty where one stands alone.
    base_misfits, other_laws : tuple of str
        Shapes that the base laws need, and laws that only bend them; laws that took the place of others.
    bends_like : str
        Where nothing is missing, the mechanism that would bend a law of the base as this sensor's is bent; empty if
        none would.
    depends_on : tuple of (channel, coordinate, share)
        What the final model's residual depends on, and the share of it that a free-form map explains.
    left : float
        What the final model leaves of the calibration error above the noise, over what the bent base leaves; 1 where
        nothing was put in.
    before, after : ModelFile
        The user's model as it is, or the baseline; and with what was found put in and refitted.
    error_before, error_after, noise_floor : mapping of channel to float
        Held-out RMS in N and in ln S. Nothing was selected on these samples; free in them are the zero of force, the
        gain of the conductance, and what of an effect belongs to one recording.
    """

    verdict: Verdict
    probabilities: Mapping[str, float]
    found: tuple[Found, ...]
    ranking: tuple[Ranked, ...]
    tied: tuple[str, ...]
    base_misfits: tuple[str, ...]
    other_laws: tuple[str, ...]
    bends_like: str
    depends_on: tuple[tuple[str, str, float], ...]
    left: float
    before: ModelFile
    after: ModelFile
    error_before: Mapping[str, float]
    error_after: Mapping[str, float]
    noise_floor: Mapping[str, float]

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form; the shape is documented in docs/finding-effects.md."""
        return {
            "verdict": self.verdict,
            "probabilities": dict(self.probabilities),
            "found": [vars(one) for one in self.found],
            "ranking": [one.to_dict() | {"tied_for_first": one.effect in self.tied} for one in self.ranking],
            "tied": list(self.tied),
            "base_misfits": list(self.base_misfits),
            "other_laws": list(self.other_laws),
            "bends_like": self.bends_like,
            "depends_on": [
                {"channel": channel, "coordinate": coordinate, "gain": gain}
                for channel, coordinate, gain in self.depends_on
            ],
            "left_unexplained": self.left,
            "error_before": dict(self.error_before),
            "error_after": dict(self.error_after),
            "noise_floor": dict(self.noise_floor),
            "model_before": self.before.model.to_dict(),
            "model_after": self.after.model.to_dict(),
            "parameters_after": dict(self.after.fit),
            "history": [dict(step) for step in self.after.history],
        }


def diagnose(
    recording: Recording | Sequence[Recording],
    held_out: Recording | None = None,
    model: KnitModel | ModelFile | None = None,
    catalogue: Catalogue | None = None,
    progress: Progress | None = None,
    most: int = constants.ROUNDS,
    clamp_play_mm: float = 0.0,
    rest_s: float = REST_S,
) -> Diagnosis:
    """Find out which physical effects a model is missing.

    Parameters
    ----------
    recording : Recording, or sequence of Recording
        To calibrate on; everything is selected on it. Several are of one specimen, in the order in which they were
        made: one history.
    held_out : Recording, optional
        For the final error; default the last third of `recording`. Several recordings need one, made after them.
    model : KnitModel or ModelFile, optional
        Start from this model instead of the baseline. One that was fitted is the first step of the ladder as it is,
        with the errors that `compare` shows; a bare one is fitted first.
    catalogue : Catalogue, optional
        Effects to consider.
    progress : callable, optional
        Called with a short text at each step.
    most : int
        Effects to find at most.
    clamp_play_mm : float
        The sensor was clamped anew for `held_out`, and for each of several recordings: the zero of its displacement
        is free, within so many mm.
    rest_s : float
        Between several recordings.

    Raises
    ------
    UserError
        If the recordings are too short or still, have a constant channel, or do not fit together.
    """
    catalogue = catalogue or load_catalogue()
    every = [recording] if isinstance(recording, Recording) else list(recording)
    calibration, held = calibration_and_held_out(every, held_out, clamp_play_mm, rest_s)
    given = model if isinstance(model, ModelFile) and model.fit else None
    start = model.model if isinstance(model, ModelFile) else model
    pieces = constants.INDEPENDENT * len(every)
    search, rounds, put_in = searched(calibration, catalogue, most, start, progress, pieces)
    return concluded(search, rounds, put_in, calibration, held, given)


def calibration_and_held_out(
    recordings: Sequence[Recording], held_out: Recording | None, clamp_play_mm: float = 0.0, rest_s: float = REST_S
) -> tuple[Measurement, Measurement]:
    """What is calibrated on, one history of all recordings, and what is held out, which comes after them."""
    calibration, held = split(recordings[0], held_out, clamp_play_mm=clamp_play_mm)
    if len(recordings) > 1:
        if held_out is None:
            raise UserError("several recordings are one history: say with --held-out which other one to judge on")
        if not 0 < rest_s < MOST_REST_S:
            raise UserError(f"rest_s: must be more than 0 and less than {MOST_REST_S:g} s, got {rest_s:g}")
        rests_s = [rest_s] * len(recordings)
        calibration = joined(recordings, rests_s[1:], clamp_play_mm)
        if calibration.channels != held.channels:
            shared, needed = (", ".join(one.channels) or "no channel" for one in (calibration, held))
            raise UserError(
                f"the recordings share {shared}, but {held.recording.source} has {needed}; all need the same channels"
            )
        held = last_of([*recordings, held_out], rests_s, clamp_play_mm)
    return calibration, held


def _before(given: ModelFile | None, search: Search, calibration: Measurement, held: Measurement) -> ModelFile:
    """The first step of the ladder: a model that was fitted is not fitted anew, so that it keeps its errors."""
    if given is None:
        return on_the_ladder(_as_used(search.baseline), None, "baseline", calibration, held)
    return as_a_step(given.model, given.fit, None, "baseline", calibration, held)


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
    whole = whole_of(rounds, put_in)
    left = whole.left if whole else 1.0
    lead = leading(put_in)
    most, beside = rounds[lead], whole_of(rounds[lead:], put_in[lead:])
    after = _ladder(search, bare, put_in, before, calibration, held)
    other_laws = search.other_laws(before.model, after.model)
    known = {*before.model, *other_laws, *(entry.name for entry in put_in)}
    weighed = dict.fromkeys(name for step in rounds[: lead + 1] for name in step.laws)
    meant = most.probabilities(beside)
    chances = mixed_with_prior(meant, prior_of(weighed), constants.MISLED)
    explained = mapped(put_in[-1].hypothesis if put_in else bare, rounds[-1].likelihood).gains
    return Diagnosis(
        verdict,
        chances,
        tuple(_found(rounds[k:], put_in[k:]) for k in sorted(range(len(put_in)), key=lambda k: k != lead)),
        _ranking(rounds[: lead + 1], chances, held),
        _tied(meant, verdict),
        tuple(name for name in after.model if name not in known),
        tuple(other_laws.values()),
        first.bend.mechanism if first.bend and verdict == "nothing_missing" else "",
        tuple(sorted(((c, where, share) for (c, where), share in explained.items()), key=lambda one: -one[2])),
        left,
        before,
        after,
        before.history[-1]["errors"]["held_out"],
        after.history[-1]["errors"]["held_out"],
        noise_floors(held),
    )


def _found(rounds: Sequence[Round], put_in: Sequence[Entry]) -> Found:
    """The first of the effects that were put in, of which each of the rounds has one."""
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
    if isinstance(own, Proposal):
        gain = 2 * max(own.gain, 0.0) / (step.likelihood.count * len(step.likelihood.floor))
        left = float(np.exp(-0.5 * gain))
        return Ranked(own.mechanism, own.law, chance, own.gain, gain, left, None, own.effect)
    h, base = own.hypothesis, step.before.hypothesis
    gain = float(np.mean([2 * np.log(base.evidence.sigma[c] / s) for c, s in h.evidence.sigma.items()]))
    over = gain_interval(bare, block_energies(h.model, held))
    return Ranked(own.mechanism, own.law, chance, step.added(own), gain, step.left(own), over, h.model[own.name])


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
