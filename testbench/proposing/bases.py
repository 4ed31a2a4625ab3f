"""Which laws of the catalogue the base is made of, beside which a law of its own is sought."""

from __future__ import annotations

from testbench.diagnosis.searching.search import Search
from testbench.fitting.baseline import without_shapes
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.laplace import fitted
from testbench.knit.model import KnitModel
from testbench.proposing.trial import TIED_NATS


def best_base(search: Search) -> Hypothesis:
    """The base whose laws were exchanged one by one for others of the catalogue while the evidence rose.

    A curve or a friction of the wrong kind leaves more than its shapes can mend, and what it leaves looks like a law
    that is missing. The diagnosis chooses its base in the same way. What is tied with the usual base stays out.
    """
    search.tell("choosing the laws of the base")
    bent, _ = search.bases()
    chosen = fitted(bent[0].model, search.likelihood, search.reference, bent[0])
    return chosen if chosen.log_z > search.flexible.log_z + TIED_NATS else search.flexible


def stiff_start(search: Search, base: Hypothesis) -> KnitModel:
    """The laws of a base where they lie without their shapes: a fit that shall not begin bent begins there."""
    if base is search.flexible:
        return search.start
    return fitted(without_shapes(base.model), search.likelihood, search.reference).model
