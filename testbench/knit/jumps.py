"""Moments at which the misfit jumps: what sets a slipping clamp apart from a knit that grows longer."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import FloatArray, Signals

WINDOW_S = 0.3  # long enough to average the noise, short enough that the misfit runs straight
SKIP_S = 0.05  # around the jump itself, which the averaging of samples blurs
APART_S = 1.0
LEAST = 7.0  # in standard deviations of what the noise and the bends of the misfit make where nothing jumps
MAD_TO_SD = 1.4826


def slip_times_s(signals: Signals, residual: Signals, dt_s: float) -> tuple[float, ...]:
    """Moments at which the knit seems to have slipped, the clearest first [s].

    Straight lines are fitted to the misfit just before and just after each sample; where they do not meet, by far
    more than the noise makes and than elsewhere, something jumped. A slip lowers the force, and comes on the way out.

    Parameters
    ----------
    signals : mapping of str to ndarray, each shape (n,)
        ``time_s`` and ``strain``.
    residual : mapping of str to ndarray, each shape (n,)
        Measured minus modelled: ``force`` in N, ``conductance`` in ln S.
    """
    outward = np.gradient(signals["strain"]) > 0
    squared = np.zeros(len(outward))
    for channel, values in residual.items():
        jump = jumps(values, dt_s)
        score = jump / _usual(values, jump, dt_s)
        squared += np.minimum(score, 0.0) ** 2 if channel == "force" else score**2
    clear = np.where(outward, np.sqrt(squared), 0.0) / LEAST
    return tuple(float(signals["time_s"][i]) for i in _peaks(clear, dt_s))


def jumps(x: FloatArray, dt_s: float) -> FloatArray:
    """Line through what follows minus line through what came before, both at each sample, shape (n,)."""
    count, skip = _lengths(dt_s)
    k = np.arange(count) + skip
    # weights of a straight line's value at k = 0 from its values at k
    centred = k - k.mean()
    weights = 1 / count - centred * k.mean() / np.sum(centred**2)
    ahead = np.concatenate([np.zeros(skip), weights])
    out = np.zeros_like(x)
    if len(x) > 2 * len(ahead):
        after = np.correlate(x, ahead, mode="valid")
        before = np.correlate(x, ahead[::-1], mode="valid")
        first = len(ahead) - 1
        out[first : len(x) - first] = after[first:] - before[: len(before) - first]
    return out


def _lengths(dt_s: float) -> tuple[int, int]:
    return max(int(WINDOW_S / dt_s), 6), max(round(SKIP_S / dt_s), 1)


def _usual(x: FloatArray, jump: FloatArray, dt_s: float) -> float:
    """Standard deviation of `jump` where nothing jumps: what the noise makes, and what lines miss in this misfit."""
    count, _ = _lengths(dt_s)
    noise = MAD_TO_SD * float(np.median(np.abs(np.diff(x, 2)))) / np.sqrt(6)
    return max(noise * np.sqrt(8 / count), MAD_TO_SD * float(np.median(np.abs(jump))), 1e-300)


def _peaks(score: FloatArray, dt_s: float) -> list[int]:
    """Indices of the largest scores above 1, apart from each other, largest first."""
    left, apart = score.copy(), int(APART_S / dt_s)
    found: list[int] = []
    while np.max(left) > 1:
        at = int(np.argmax(left))
        found.append(at)
        left[max(at - apart, 0) : at + apart] = 0
    return found
