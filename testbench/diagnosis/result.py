"""What a diagnosis says: the verdict, the probabilities, and the ladder of models."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gcode.support.read_only import Unchanging, free_copy
from testbench.diagnosis.held_out import Interval
from testbench.diagnosis.judging.rounds import Verdict
from testbench.knit.effect import Effect
from testbench.results.model_file import ModelFile


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
class Diagnosis(Unchanging):
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
        fitted = {
            "model_before": self.before.model.to_dict(),
            "model_after": self.after.model.to_dict(),
            "parameters_after": free_copy(self.after.fit),
        }
        return self.findings() | fitted | {"history": free_copy(list(self.after.history))}

    def findings(self) -> dict[str, Any]:
        """What is said in words: as `to_dict`, without the models; the history is the one that `after` keeps."""
        return {
            "verdict": self.verdict,
            "probabilities": dict(self.probabilities),
            "found": [dict(vars(one)) for one in self.found],
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
            "history": self.after.history,
        }
