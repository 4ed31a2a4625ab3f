"""What is said at the end: an effect is missing, nothing is, or something is that nobody knows."""

from __future__ import annotations

from typing import Literal

from testbench.discrepancy.evidence import Weighing
from testbench.discrepancy.remains import Remains

Verdict = Literal["missing", "nothing_missing", "unknown"]

# Set on simulated sensors whose physics is written apart from this model (benchmarks/bench_diagnosis.py).
# An idea must gain this much to be called missing, and the second if no shape of the base could imitate it: then the
# least that a true one gained was 0.28 (331 sensors), and a false one had 0.12.
GAIN_TO_NAME, GAIN_TO_NAME_WITHOUT_RIVAL = 0.075, 0.15
AT_THE_NOISE, STRUCTURE_OVER_NOISE = 1.2, 2.0  # errors of fewer noise floors have none, of more have structure
# What leaves more than this share of the error above the noise, and structure, is a stand-in for something else;
LEFT_UNEXPLAINED = 0.15
# but so far above the noise several effects are missing at once, and one that explains half of it is worth its name.
FAR_OVER_NOISE, LEFT_FAR_OVER_NOISE, LARGE_GAIN = 10.0, 0.6, 0.5
STAND_IN_MAY_COST = 1.05  # times the error of the base, for an effect in the place of one of its shapes
# Of two neighbours that leave structure neither is named: how near they are, when the noise is not reached, and what
# a free-form map may still explain.
NEAR, NEARLY_AT_THE_NOISE, NEARLY_ALL_EXPLAINED, STRUCTURE_LEFT = 0.6, 1.25, 0.035, 0.06
SMALL_GAIN, CROWD = 0.25, 2  # a small gain that so many other ideas half share is the base's own misfit


def verdict_of(weighing: Weighing, left: Remains, typical: Remains) -> Verdict:
    """Missing, nothing missing, or unknown, from the gains and from what is left over.

    Parameters
    ----------
    weighing : Weighing
    left : Remains
        Of the held-out error of the base, with the first idea put in.
    typical : Remains
        The same without the few samples that fit worst. What is left in them alone says nothing against an idea.
    """
    unnamed: Verdict = "unknown" if left.after > STRUCTURE_OVER_NOISE else "nothing_missing"
    if not weighing.ranking:
        return unnamed
    first = weighing.ranking[0]
    if first.seen:
        return "missing"
    effect, gain = first.candidate.effect, first.gain
    # What makes the held-out error larger is not named, whatever it gained in calibration. What stands in for a shape
    # of the base has to do as well as the shape; all else has to do better than the base, if there is room.
    worse = left.after > STAND_IN_MAY_COST * left.before if effect.imitable else left.share >= 1.0
    least = GAIN_TO_NAME if effect.imitable else GAIN_TO_NAME_WITHOUT_RIVAL
    if gain <= least or _crowded(weighing) or worse:
        return unnamed
    if left.before < AT_THE_NOISE and not effect.imitable:
        return "nothing_missing"
    if effect.quick:
        return "missing"
    most_left = LEFT_FAR_OVER_NOISE if left.before > FAR_OVER_NOISE and gain > LARGE_GAIN else LEFT_UNEXPLAINED
    explains = any(one.share <= most_left or one.after <= STRUCTURE_OVER_NOISE for one in (left, typical))
    return "missing" if explains else "unknown"


def among_neighbours(weighing: Weighing, left: Remains, typical: Remains) -> bool:
    """Whether another idea comes near the first, and the first does not reach the noise: it may be neither.

    What is there explains itself to the noise, or leaves its neighbours far behind. (What stands in for a shape of
    the base is compared with a base that bends, which leaves little anyway.) Whether what stays is structure, or
    noise that wanders more slowly than the floor counts, `testbench.discrepancy.evidence.structure_left` tells.
    """
    first, *others = weighing.ranking
    near = any(entry.gain > NEAR * first.gain for entry in others) and not first.candidate.effect.imitable
    return near and not first.seen and typical.after > NEARLY_AT_THE_NOISE and left.share > NEARLY_ALL_EXPLAINED


def _crowded(weighing: Weighing) -> bool:
    """Whether a small gain is shared by many ideas: then each nibbles at a misfit that belongs to none of them."""
    first, *others = (entry.gain for entry in weighing.ranking)
    return first < SMALL_GAIN and sum(gain > 0.5 * first for gain in others) >= CROWD
