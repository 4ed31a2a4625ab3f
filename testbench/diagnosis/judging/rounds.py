"""One round of the search: what was weighed, and the probabilities that follow."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.special import logsumexp

from testbench.diagnosis.judging.entries import Entry, Proposal, Whole
from testbench.diagnosis.judging.order import best_first, first_of_each
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
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.likelihood import Likelihood

LEFT_AT_MOST = 0.5  # of what laws should explain, by those that are named
EITHER = -float(np.log(2))  # log prior of each of two that are as likely
Verdict = Literal["missing", "nothing_missing", "unknown"]


@dataclass(frozen=True, eq=False)
class Round:
    """One step: the model so far against the same with each mechanism added.

    Attributes
    ----------
    before : Entry
        The model so far, at its best.
    entries : tuple of Entry
        What was refitted, the best first.
    proposals : tuple of Proposal
        Every law of the catalogue, to first order.
    laws : mapping of mechanism to int
        Laws that speak for it.
    likelihood : Likelihood
    explained_before : mapping of channel to float
        Standard deviation of what the laws explain that were put in before; empty in the first round.
    dead_ends : set of str
        Mechanisms from which the search has gone on already, and come to less.
    """

    before: Entry
    entries: tuple[Entry, ...]
    proposals: tuple[Proposal, ...]
    laws: Mapping[str, int]
    likelihood: Likelihood
    explained_before: Mapping[str, float] = field(default_factory=dict)
    dead_ends: frozenset[str] = frozenset()

    @cached_property
    def prior(self) -> dict[str, float]:
        """What is believed of every hypothesis before the data."""
        return prior_of(self.laws)

    @property
    def log_z_nothing(self) -> float:
        """Log evidence that nothing is missing; see `_nothing`."""
        return float(logsumexp(list(self._nothing().values())))

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
        return e.log_z + self._complete(e, everywhere=True)

    def _log_prior_bend(self, e: Entry) -> float:
        """Of a base that is bent as an entry would bend it, less what laws summed owe to luck."""
        return e.log_prior_bend - self.luck

    def by_law(self, entry: Entry) -> dict[str, float]:
        """Standard deviation of what a law explains, per channel.

        That is what the error falls by, or more where the base has bent to do the same.
        """
        fall = explained(self.before.hypothesis, entry.hypothesis)
        return {c: max(some, entry.own_part.get(c, 0.0)) for c, some in fall.items()}

    def _complete(self, entry: Entry, everywhere: bool = False) -> float:
        """How much likelier what an entry leaves is if no more is missing.

        A law errs in proportion to what it does. It is asked for the channels that it changes, and that nothing is
        missing for all.
        """
        by_law, sigma = self.by_law(entry), entry.hypothesis.evidence.sigma
        asked = sigma if everywhere else self.changed_by(entry)
        return self.likelihood.noise_log_prior({c: sigma[c] for c in asked}, by_law, entry.whole_part)

    def changed_by(self, *put_in: Entry) -> list[str]:
        """Channels that one of these laws changes by more than the least misfit; others may lack something else."""
        least = self.likelihood.least_misfit
        changed = {c for e in put_in for c, some in self.by_law(e).items() if some > least[c]}
        return [c for c in least if c in changed or not changed]

    def added(self, entry: Entry) -> float:
        """Log evidence that an entry adds to the model so far, whatever it leaves."""
        return entry.hypothesis.log_z - self.before.hypothesis.log_z

    def left(self, *put_in: Entry) -> float:
        """Share of what laws should explain that the last of them leaves, one put in after the other.

        They are asked for the channels that they change.
        """
        return self._left_in(self.changed_by(*put_in), put_in)

    def left_everywhere(self, *put_in: Entry) -> float:
        """The same of all channels."""
        return self._left_in(self.likelihood.floor, put_in)

    def _left_in(self, channels: Collection[str], put_in: Sequence[Entry]) -> float:
        """The error above the least misfit (an error of that size is none), as a share of what it was before.

        Or of what the laws change themselves, where the base has bent to do the same.
        """
        left, before = (excess(e.hypothesis, self.likelihood, channels) for e in (put_in[-1], self.before))
        by_laws = sum(squared(e.own_part, self.likelihood, channels) for e in put_in)
        return float(np.sqrt(max(left - 1.0, 0.0) / max(before, by_laws, 1.0)))

    def is_all(self, put_in: Entry) -> bool:
        """Whether what was put in leaves nothing to look for: no more than a law is expected to leave."""
        misfit, sigma = self.likelihood.misfit, put_in.hypothesis.evidence.sigma
        is_enough = all(left < 1.001 * misfit[c] for c, left in sigma.items())
        return is_enough and (self.is_named() or put_in is self.bend)

    def probabilities(self, whole: Whole | None = None) -> dict[str, float]:
        """Of nothing, of unknown and of each mechanism to be what is missing most; they sum to 1.

        In the mean over the errors of the evidences; `whole` as in `evidences`.
        """
        return over_errors(self.evidences(whole))

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

    def _of_any(self, whole: Whole | None) -> dict[str, float]:
        """Log evidence of an effect of no catalogue, by source: unlike every law, or in part like one, as likely.

        A law that resembles it is worth as much as if it were what is missing. What is left may be of any size.
        """
        alike = [(e.mechanism, self.log_prior_alike(e.mechanism) + e.log_z + EITHER) for e in self.entries]
        if whole and whole.first_adds is not None:  # a single law is among the entries
            alike.append((whole.first, whole.log_prior_alike + whole.log_z + EITHER))
        return by_source([(SO_FAR, self.before.log_z + EITHER), *alike])

    def log_prior_alike(self, mechanism: str) -> float:
        """Of one law of a mechanism, if it is one of the catalogue."""
        return self.log_prior(mechanism) - float(np.log(1 - self.prior[NOTHING] - self.prior[UNKNOWN]))

    def doubted(self, whole: Whole | None = None) -> dict[str, float]:
        """The probabilities as they are told; `whole` as in `probabilities`."""
        return mixed_with_prior(self.probabilities(whole), self.prior, constants.MISLED)

    def log_prior(self, mechanism: str) -> float:
        """Of one law of a mechanism, less what laws summed owe to luck."""
        return float(np.log(self.prior[mechanism] / self.laws[mechanism]) - self.luck)

    @property
    def luck(self) -> float:
        """What a sum of evidences owes to luck, in nats; that nothing is missing was not chosen among many.

        Evidences are known within `EVIDENCE_ERROR`, and the mean of exp(error) is exp(sd^2 / 2) (log-normal).
        """
        return constants.EVIDENCE_ERROR**2 / 2

    def log_z_alone(self, entry: Entry) -> float:
        """Log evidence that an entry, and nothing else, is missing."""
        return entry.log_z + self._complete(entry)

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
    def goes_in(self) -> Entry | None:
        """What goes in so that the search goes on: the candidate, or where that explains too little, what adds most.

        Of several effects of one size none explains all that is there, and the one that comes nearest to explaining
        some channel to its end need not be among them.
        """
        if self.candidate is None or self.is_named():
            return self.candidate
        return max(self.entries, key=self.added)

    @cached_property
    def begins(self) -> list[Entry]:
        """The laws that a search may begin with, the most promising first.

        Where the verdict would be *unknown*, that is the best law of every mechanism, in order of what it adds.
        """
        first = self.goes_in or self.bend
        if self.verdict() != "unknown" or first is not self.goes_in:
            return [first] if first else []
        adding = sorted((e for e in self.entries if self.added(e) > 0), key=self.added, reverse=True)
        return first_of_each(adding, lambda e: e.mechanism)

    def with_entry(self, better: Entry) -> Round:
        """The same with a law that was fitted better meanwhile."""
        entries = (better if e.law == better.law else e for e in self.entries)
        return replace(self, entries=tuple(best_first(entries)))

    @cached_property
    def candidate(self) -> Entry | None:
        """The best law of the most probable mechanism, if it is more probable than nothing."""
        if not self.entries:
            return None
        mechanism = max(dict.fromkeys(e.mechanism for e in self.entries), key=self._log_posterior)
        if self._log_posterior(mechanism) < np.log(self.prior[NOTHING]) + self.log_z_nothing:
            return None
        return max((e for e in self.entries if e.mechanism == mechanism), key=self.log_z_alone)

    @cached_property
    def bend(self) -> Entry | None:
        """The law by which a law of the base is bent, if most speaks for that: the search goes on beside it."""
        best = self.candidate or max(self.entries, key=self._log_z_bent, default=None)
        if best is None or not self.is_bend(best):
            return None
        return best if self._log_prior_bend(best) + best.log_z > self.before.log_z else None

    def is_bend(self, e: Entry) -> bool:
        """Whether an entry rather says that a law of the base is bent than that an effect is missing."""
        return self._log_prior_bend(e) + EITHER > self.log_prior(e.mechanism)

    def verdict(self, whole: Whole | None = None) -> Verdict:
        """What is said of the model before this round; `whole`, as in `probabilities`, is for what has a name.

        A mechanism that is probable and explains too little is no name, but something is missing.
        """
        if self.is_named(whole):
            return "missing"
        told = self.doubted()
        nothing, unknown = told[NOTHING], told[UNKNOWN]
        return "nothing_missing" if nothing >= unknown and nothing + unknown >= 0.5 else "unknown"

    def is_named(self, whole: Whole | None = None) -> bool:
        """Whether some mechanism is more probable than nothing and unknown together, and explains most."""
        if self.candidate is None:
            return False
        chances = self.probabilities(whole)
        left = whole.left if whole else self.left(self.candidate)
        return chances[NOTHING] + chances[UNKNOWN] < 0.5 and left <= LEFT_AT_MOST


def explained(without: Hypothesis, with_it: Hypothesis) -> dict[str, float]:
    """Standard deviation of what an effect explains, per channel."""
    before, after = without.evidence.sigma, with_it.evidence.sigma
    return {c: float(np.sqrt(max(before[c] ** 2 - after[c] ** 2, 0.0))) for c in before}


def squared(change: Mapping[str, float], likelihood: Likelihood, channels: Collection[str]) -> float:
    """What a law changes, squared, in units of the least that one leaves, summed over the channels."""
    least = likelihood.least_misfit
    return sum((change.get(c, 0.0) / least[c]) ** 2 for c in channels)


def excess(h: Hypothesis, likelihood: Likelihood, channels: Collection[str] | None = None) -> float:
    """Squared error above the least that a law leaves, in units of it, summed over the channels; default all."""
    least, sigma = likelihood.least_misfit, h.evidence.sigma
    return sum(max((sigma[c] / least[c]) ** 2 - 1, 0.0) for c in channels or sigma)
