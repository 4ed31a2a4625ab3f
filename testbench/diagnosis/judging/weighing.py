"""What is missing: the log evidence of every hypothesis in one round, and the probabilities that follow."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.special import logsumexp

from testbench.comparing.carried_over import LEFT_AT_MOST
from testbench.diagnosis.judging.comparison import ModelComparison
from testbench.diagnosis.judging.entries import Entry, Proposal, Whole
from testbench.diagnosis.judging.probabilities import (
    NOTHING,
    SO_FAR,
    UNKNOWN,
    Evidences,
    by_source,
    mixed_with_prior,
    over_errors,
    prior_of,
)
from testbench.fitting import constants

EITHER = -float(np.log(2))  # log prior of each of two that are as likely


@dataclass(frozen=True, eq=False)
class Weighing(ModelComparison):
    """The hypotheses of one round: nothing is missing, a mechanism is, or something that no law describes.

    Attributes
    ----------
    entries : tuple of Entry
        What was refitted, the best first.
    proposals : tuple of Proposal
        Every law of the catalogue, to first order.
    laws : mapping of mechanism to int
        Laws that speak for it.
    explained_before : mapping of channel to float
        Standard deviation of what the laws explain that were put in before; empty in the first round.
    dead_ends : set of str
        Mechanisms from which the search has gone on already, and come to less.
    """

    entries: tuple[Entry, ...]
    proposals: tuple[Proposal, ...]
    laws: Mapping[str, int]
    explained_before: Mapping[str, float] = field(default_factory=dict)
    dead_ends: frozenset[str] = frozenset()

    @cached_property
    def prior(self) -> dict[str, float]:
        """What is believed of every hypothesis before the data."""
        return prior_of(self.laws)

    def log_prior(self, mechanism: str) -> float:
        """Of one law of a mechanism, less what laws summed owe to luck."""
        return float(np.log(self.prior[mechanism] / self.laws[mechanism]) - self.luck)

    def log_prior_alike(self, mechanism: str) -> float:
        """Of one law of a mechanism, if it is one of the catalogue."""
        return self.log_prior(mechanism) - float(np.log(1 - self.prior[NOTHING] - self.prior[UNKNOWN]))

    @property
    def luck(self) -> float:
        """What a sum of evidences owes to luck, in nats; that nothing is missing was not chosen among many.

        Evidences are known within `EVIDENCE_ERROR`, and the mean of exp(error) is exp(sd^2 / 2) (log-normal).
        """
        return constants.EVIDENCE_ERROR**2 / 2

    @property
    def least_asked(self) -> float:
        """What a law must add, in nats, to be as probable as that nothing is missing."""
        asked = np.log(self.prior[NOTHING]) + EITHER - np.log(max(self.prior[m] for m in self.laws))
        return float(asked) + self.luck

    def probabilities(self, whole: Whole | None = None) -> dict[str, float]:
        """Of nothing, of unknown and of each mechanism to be what is missing most; they sum to 1.

        In the mean over the errors of the evidences; `whole` as in `evidences`.
        """
        return over_errors(self.evidences(whole))

    def doubted(self, whole: Whole | None = None) -> dict[str, float]:
        """The probabilities as they are told; `whole` as in `probabilities`."""
        return mixed_with_prior(self.probabilities(whole), self.prior, constants.MISLED)

    def evidences(self, whole: Whole | None = None) -> Evidences:
        """Log prior and evidence of each hypothesis about what is missing most.

        Parameters
        ----------
        whole : Whole, optional
            All that was put in from here on, together. Two effects of one size leave each other's part, by which
            either alone is worse than a free-form map; together they are not.
        """
        logs = {mechanism: self._log_posterior(mechanism) for mechanism in self.laws}
        if whole and whole.first_adds is not None:
            # In company none need explain all: in place of the first each is less probable by what it adds less,
            # alone or beside the others.
            weighed = self._log_posterior if self.is_named() else self._log_in_part
            adds = max(weighed(whole.first), self.log_prior(whole.first) + whole.first_adds)
            for m in logs.keys() - self.dead_ends - {whole.first}:
                logs[m] = float(np.logaddexp(logs[m], weighed(m) - adds + whole.log_posterior))
            logs[whole.first] = float(np.logaddexp(logs[whole.first], whole.log_posterior))
        parts = {mechanism: {mechanism: log} for mechanism, log in logs.items()}
        parts[NOTHING] = {source: log + np.log(self.prior[NOTHING]) for source, log in self._nothing().items()}
        parts[UNKNOWN] = {source: log + np.log(self.prior[UNKNOWN]) for source, log in self._of_any(whole).items()}
        return parts

    def _nothing(self) -> dict[str, float]:
        """Log evidence that nothing is missing, by source: what is left is then noise, whose size is known.

        The laws of the base are those of the sensor, or one of them is bent as an effect would bend it, as likely.
        The laws that were put in are not quite those of the sensor either.
        """
        bent = [(e.mechanism, self._log_z_bent(e) + EITHER) for e in self.entries]
        erring = [(e.mechanism, self._log_prior_error(e) + self._log_z_everywhere(e)) for e in self.entries]
        return by_source([(SO_FAR, self.log_z_alone(self.before) + EITHER), *bent, *erring])

    def _log_prior_error(self, e: Entry) -> float:
        """Log probability that the laws put in before err by what an entry explains, so that no more is missing.

        They err as any law of the catalogue would, all alike.
        """
        if not self.explained_before:
            return -np.inf
        error = self.likelihood.expected(self.explained_before)
        size = sum((some / error[c]) ** 2 for c, some in self.by_law(e).items())
        return float(-0.5 * size - np.log(sum(self.laws.values()))) - self.luck

    def _log_z_bent(self, e: Entry) -> float:
        return self._log_prior_bend(e) + self._log_z_everywhere(e)

    def _log_z_everywhere(self, e: Entry) -> float:
        """Log evidence of an entry beside which nothing is missing in any channel."""
        return e.log_z + self.log_odds_complete(e, everywhere=True)

    def _log_prior_bend(self, e: Entry) -> float:
        """Of a base that is bent as an entry would bend it, less what laws summed owe to luck."""
        return e.log_prior_bend - self.luck

    def _of_any(self, whole: Whole | None) -> dict[str, float]:
        """Log evidence of an effect of no catalogue, by source: unlike every law, or in part like one, as likely.

        A law that resembles it is worth as much as if it were what is missing. What is left may be of any size.
        """
        alike = [(e.mechanism, self.log_prior_alike(e.mechanism) + e.log_z + EITHER) for e in self.entries]
        if whole and whole.first_adds is not None:  # a single law is among the entries
            alike.append((whole.first, whole.log_prior_alike + whole.log_z + EITHER))
        return by_source([(SO_FAR, self.before.log_z + EITHER), *alike])

    def _log_posterior(self, mechanism: str) -> float:
        """Log prior and evidence of a mechanism to be what is missing, and nothing else."""
        return self._summed(mechanism, self.log_z_alone)

    def _log_in_part(self, mechanism: str) -> float:
        """Log prior of a mechanism, and the evidence that it adds, whatever it leaves."""
        return self._summed(mechanism, self.added)

    def _summed(self, mechanism: str, evidence: Callable[[Entry], float]) -> float:
        """Log prior and evidence of a mechanism, its laws summed; to first order if none was refitted."""
        own = [evidence(e) for e in self.entries if e.mechanism == mechanism]
        if not own:
            gains = (p.gain for p in self.proposals if p.mechanism == mechanism)
            own = [evidence(self.before) + min(gain, 0.0) for gain in gains]
        return self.log_prior(mechanism) + float(logsumexp(own))

    @cached_property
    def candidate(self) -> Entry | None:
        """The best law of the most probable mechanism, if it is more probable than nothing.

        Which law that is, is asked without a free-form map: it goes into the model without one, and what a map takes
        over from a poorer law foretells nothing.
        """
        if not self.entries:
            return None
        mechanism = max(dict.fromkeys(e.mechanism for e in self.entries), key=self._log_posterior)
        if self._log_posterior(mechanism) < np.log(self.prior[NOTHING]) + logsumexp(list(self._nothing().values())):
            return None
        laws = (e for e in self.entries if e.mechanism == mechanism)
        return max(laws, key=lambda e: self.added(e) + self.log_odds_complete(e))

    def is_named(self, whole: Whole | None = None) -> bool:
        """Whether some mechanism is more probable than nothing and unknown together, and explains most."""
        if self.candidate is None:
            return False
        chances = self.probabilities(whole)
        left = whole.left if whole else self.left(self.candidate)
        return chances[NOTHING] + chances[UNKNOWN] < 0.5 and left <= LEFT_AT_MOST
