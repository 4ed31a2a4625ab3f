"""What a search put in, one law a round, weighed as a whole."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbench.diagnosis.judging.entries import Entry, Whole
from testbench.diagnosis.judging.rounds import Round


def whole_of(rounds: Sequence[Round], put_in: Sequence[Entry]) -> Whole | None:
    """What was put in, one in each round; None if nothing was."""
    if not put_in:
        return None
    steps, last = rounds[: len(put_in)], put_in[-1]
    prior = sum(step.log_prior(e.mechanism) for step, e in zip(steps, put_in, strict=True))
    alike = sum(step.log_prior_alike(e.mechanism) for step, e in zip(steps, put_in, strict=True))
    adds = None
    if len(put_in) > 1:
        rest = put_in[0].without
        adds = last.log_z - rest.log_z if rest else 0.0
    log_posterior = prior + steps[-1].log_z_alone(last)
    return Whole(log_posterior, last.log_z, alike, steps[0].left(*put_in), put_in[0].mechanism, adds)


def leading(put_in: Sequence[Entry]) -> int:
    """Which of several effects the model misses most without it: the first to be found need not be it.

    Judged without a free-form map of what is left, beside which no effect is missed much.
    """
    without = [e.without.hypothesis.log_z for e in put_in if e.without]
    return int(np.argmin(without)) if without else 0


def log_posterior_of(walk: tuple[Sequence[Round], Sequence[Entry]]) -> float:
    """Log prior and evidence of what a search put in; minus infinity if that is nothing."""
    whole = whole_of(*walk)
    return whole.log_posterior if whole else -np.inf


def best_set(rounds: Sequence[Round], put_in: Sequence[Entry]) -> list[Entry]:
    """What was put in, or the first candidate where that alone is as probable; empty if there is none."""
    alone = rounds[0].candidate
    if alone is None:
        return []
    whole, single = whole_of(rounds, put_in), whole_of(rounds[:1], [alone])
    in_company = len(put_in) > 1 and whole and single and whole.log_posterior > single.log_posterior
    return list(put_in) if in_company else [alone]
