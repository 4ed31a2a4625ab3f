"""One model beside the same with a law put in: what the law explains, and what it leaves."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from testbench.diagnosis.judging.entries import Entry
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.likelihood import Likelihood


@dataclass(frozen=True, eq=False)
class ModelComparison:
    """The model so far, against the same with a law put in.

    Attributes
    ----------
    before : Entry
        The model so far, at its best.
    likelihood : Likelihood
    """

    before: Entry
    likelihood: Likelihood

    def by_law(self, entry: Entry) -> dict[str, float]:
        """Standard deviation of what a law explains, per channel.

        That is what the error falls by, or more where the base has bent to do the same.
        """
        fall = explained(self.before.hypothesis, entry.hypothesis)
        return {c: max(some, entry.own_part.get(c, 0.0)) for c, some in fall.items()}

    def log_odds_complete(self, entry: Entry, everywhere: bool = False) -> float:
        """How much likelier what an entry leaves is if no more is missing.

        A law errs in proportion to what it does. It is asked for the channels that it changes, and that nothing is
        missing for all.
        """
        by_law, sigma = self.by_law(entry), entry.hypothesis.evidence.sigma
        asked = sigma if everywhere else self.changed_by(entry)
        return self.likelihood.log_odds_complete({c: sigma[c] for c in asked}, by_law, entry.whole_part)

    def log_z_alone(self, entry: Entry) -> float:
        """Log evidence that an entry, and nothing else, is missing."""
        return entry.log_z + self.log_odds_complete(entry)

    def changed_by(self, *put_in: Entry) -> list[str]:
        """Channels that one of these laws changes by more than the least misfit; others may lack something else."""
        least = self.likelihood.least_misfit
        changed = {c for e in put_in for c, some in self.by_law(e).items() if some > least[c]}
        return [c for c in least if c in changed or not changed]

    def added(self, entry: Entry) -> float:
        """Log evidence that an entry adds to the model so far, whatever it leaves."""
        return entry.hypothesis.log_z - self.before.hypothesis.log_z

    def left(self, *put_in: Entry, everywhere: bool = False) -> float:
        """Share of the error above the least misfit that laws leave, one put in after the other.

        Of what it was before, or of what the laws change themselves, where the base has bent to do the same. They are
        asked for the channels that they change, or for all. An error of the size of the least misfit is none.
        """
        least = self.likelihood.least_misfit
        channels = list(least) if everywhere else self.changed_by(*put_in)
        left, before = (excess(e.hypothesis, self.likelihood, channels) for e in (put_in[-1], self.before))
        by_laws = sum(sum((e.own_part.get(c, 0.0) / least[c]) ** 2 for c in channels) for e in put_in)
        return float(np.sqrt(max(left - 1.0, 0.0) / max(before, by_laws, 1.0)))


def explained(without: Hypothesis, with_it: Hypothesis) -> dict[str, float]:
    """Standard deviation of what an effect explains, per channel."""
    before, after = without.evidence.sigma, with_it.evidence.sigma
    return {c: float(np.sqrt(max(before[c] ** 2 - after[c] ** 2, 0.0))) for c in before}


def excess(h: Hypothesis, likelihood: Likelihood, channels: Collection[str] | None = None) -> float:
    """Squared error above the least that a law leaves, in units of it, summed over the channels; default all."""
    least, sigma = likelihood.least_misfit, h.evidence.sigma
    return sum(max((sigma[c] / least[c]) ** 2 - 1, 0.0) for c in channels or sigma)
