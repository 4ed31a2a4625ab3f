"""One round of the search: what goes into the model so that the search goes on, and what is said of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

from testbench.diagnosis.judging.entries import Entry, Whole
from testbench.diagnosis.judging.probabilities import NOTHING, UNKNOWN
from testbench.diagnosis.judging.ranking import best_first, first_of_each
from testbench.diagnosis.judging.weighing import EITHER, Weighing
from testbench.fitting import constants

Verdict = Literal["missing", "nothing_missing", "unknown"]


@dataclass(frozen=True, eq=False)
class Round(Weighing):
    """One step of the search, weighed; see `ModelComparison` and `Weighing` for what it has."""

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

    @cached_property
    def bend(self) -> Entry | None:
        """The law by which a law of the base is bent, if most speaks for that: the search goes on beside it."""
        best = self.candidate or max(self.entries, key=self._log_z_bent, default=None)
        if best is None or not self.is_bend(best):
            return None
        return best if self._log_prior_bend(best) + best.log_z > self.before.log_z else None

    @property
    def lean(self) -> Round:
        """The same, where only the models that the search may go on from keep their sensitivities."""
        ahead = [self.candidate, self.goes_in, self.bend, *self.begins[: constants.BEAM]]
        entries = (e if e in ahead else replace(e, hypothesis=e.hypothesis.lean) for e in self.entries)
        return replace(self, entries=tuple(entries))

    def is_bend(self, e: Entry) -> bool:
        """Whether an entry rather says that a law of the base is bent than that an effect is missing."""
        return self._log_prior_bend(e) + EITHER > self.log_prior(e.mechanism)

    def is_all(self, put_in: Entry) -> bool:
        """Whether what was put in leaves nothing to look for: no further law could earn what its prior asks."""
        left = put_in.hypothesis.evidence.sigma
        return self.likelihood.most_added(left) < self.least_asked and (self.is_named() or put_in is self.bend)

    def verdict(self, whole: Whole | None = None) -> Verdict:
        """What is said of the model before this round; `whole`, as in `probabilities`, is for what has a name.

        A mechanism that is probable and explains too little is no name, but something is missing.
        """
        if self.is_named(whole):
            return "missing"
        told = self.doubted()
        nothing, unknown = told[NOTHING], told[UNKNOWN]
        return "nothing_missing" if nothing >= unknown and nothing + unknown >= 0.5 else "unknown"

    def with_entry(self, better: Entry) -> Round:
        """The same with a law that was fitted better meanwhile."""
        entries = (better if e.law == better.law else e for e in self.entries)
        return replace(self, entries=tuple(best_first(entries)))
