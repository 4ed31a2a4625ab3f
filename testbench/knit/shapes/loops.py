"""Operators with rate-independent memory of the strain: a set of them that is rich enough for loops of any shape."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from testbench.knit.effect import FloatArray, Vector
from testbench.knit.shapes.curves import LAW_TERMS, curve_terms, kept_curve
from testbench.knit.shapes.recent import Recent

# All in parts of the span of the strain.
STOPS = tuple(np.geomspace(0.006, 1.0, 16))  # break-away
SMOOTH = tuple(np.geomspace(0.01, 0.4, 4))  # travel over which a Bouc-Wen variable turns
SKEWS = (0.0, 0.5)
WAYS = (1, 2)  # which of the smooth ones tell the way out from the way back, where the two are curves of their own
ONE_SIDED = ((0.05, 0.1), (0.1, 0.3), (0.1, 0.05), (0.3, 0.1))  # travel upwards, downwards
LOOPS = len(STOPS) + len(SMOOTH) * len(SKEWS) + len(ONE_SIDED)


def loops(
    e: FloatArray,
    span: float,
    weights: tuple[float, ...],
    growth: tuple[float, ...],
    positions: Vector = (),
) -> FloatArray:
    """Sum of the operators, each weighted by w_k + v_k u + v'_k u^2 with u = e / span, and of `positions_terms`.

    Parameters
    ----------
    e : ndarray, shape (n,)
        Strain.
    weights : tuple of float, length `LOOPS`
    growth : tuple of float, length 2 `LOOPS`
        v, then v'.
    positions : tuple of float, length of `STOPS`, optional
    """
    total = np.zeros_like(e)
    if any(growth):
        fixed, linear, square = np.reshape((*weights, *growth), (3, LOOPS)) @ _operators(e, span)
        u = e / span
        total += fixed + (linear + square * u) * u
    elif any(weights):
        total += np.asarray(weights) @ _operators(e, span)
    if any(positions):
        total += np.asarray(positions) @ positions_terms(e, span)
    return total


def loops_by_weight(weights: str, e: FloatArray, span: float) -> FloatArray:
    """What each weight of a vector of `loops` or `two_ways` adds at weight 1, shape (k, n); `weights` names it."""
    terms: dict[str, Callable[[FloatArray, float], FloatArray]] = {
        "weights": _operators,
        "growth": growth_terms,
        "positions": positions_terms,
        "ways": two_ways_terms,
    }
    return terms[weights](e, span)


def growth_terms(e: FloatArray, span: float) -> FloatArray:
    """What each weight of the `growth` of `loops` adds at weight 1, shape (2 `LOOPS`, n)."""
    fixed, u = _operators(e, span), e / span
    found = np.empty((2, *fixed.shape))
    np.multiply(fixed, u, out=found[0])
    np.multiply(found[0], u, out=found[1])
    return found.reshape(-1, len(e))


@Recent
def positions_terms(e: FloatArray, span: float) -> FloatArray:
    """What each weight of the `positions` of `loops` adds at weight 1, shape (len(STOPS), n).

    (u^2 - p_k^2) / r_k, where p_k is where the play of radius r_k stands. Relays of one width, weighted by where they
    lie, add up to the square of that position: with them the loops are those of a Preisach operator whose density
    rises or falls with strain, and an excursion leaves an offset until a larger one wipes it out.

    Source: Brokate & Sprekels, Hysteresis and Phase Transitions (1996), ch. 2 (a Preisach operator as curves over the
    positions of plays).
    """
    stops, radius = _operators(e, span)[: len(STOPS)], np.array(STOPS)[:, None]
    return stops * (2 * e / span - radius * stops)


def two_ways_terms(e: FloatArray, span: float) -> FloatArray:
    """What each weight of `two_ways` adds at weight 1, shape ``(len(WAYS) * LAW_TERMS, n)``."""
    ways, curves = _operators(e, span)[len(STOPS) + np.array(WAYS)], curve_terms(e, 0.0, span, LAW_TERMS)
    return (ways[:, None] * curves).reshape(-1, len(e))


def two_ways(e: FloatArray, span: float, weights: tuple[float, ...]) -> FloatArray:
    """One smooth curve over strain on the way out, another on the way back: half their difference, times the way.

    Parameters
    ----------
    e : ndarray, shape (n,)
        Strain.
    weights : tuple of float, length ``len(WAYS) * LAW_TERMS``
        Of `curve`, for each length of travel in which the knit goes over from one to the other.
    """
    total = np.zeros_like(e)
    for way, own in zip(WAYS, np.reshape(weights, (len(WAYS), -1)), strict=True):
        if own.any():
            total += _operators(e, span)[len(STOPS) + way] * kept_curve(e, 0.0, span, tuple(own))
    return total


@Recent
def _operators(e: FloatArray, span: float) -> FloatArray:
    """Every operator, in [-1, 1] or nearly, shape (LOOPS, n); they do not depend on any weight."""
    from testbench.knit.kernels import bouc_wen_of_exponent_1, follower, play

    sharp = np.array(STOPS) * span
    found = np.empty((LOOPS, len(e)))  # filled in place: joined from parts, an hour's table is copied once more
    stops, others = found[: len(STOPS)], iter(found[len(STOPS) :])
    np.subtract(e, play(e, sharp), out=stops)
    stops /= sharp[:, None]
    for skew in SKEWS:
        for travel, row in zip(SMOOTH, others, strict=False):
            row[:] = bouc_wen_of_exponent_1(e, travel * span, skew)
    for (up, down), row in zip(ONE_SIDED, others, strict=True):
        np.subtract(e, follower(e, up * span, down * span), out=row)
        row /= max(up, down) * span
    return found
