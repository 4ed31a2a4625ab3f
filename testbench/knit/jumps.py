"""Moments at which the misfit jumps: what sets a slipping clamp apart from a knit that grows longer."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from testbench.knit.effect import FloatArray, Signals

WINDOW_S = 0.3  # long enough to average the noise, short enough that the misfit runs straight
SKIP_S = 0.05  # around the jump itself, which the averaging of samples blurs
APART_S = 1.0
PULLED = 0.5  # quantile of the strain above which a grip may give way
LEAST_MOTION = 1e-4  # as strain: slower than this nothing is said about how steep the sensor is
LEAST = 5.0  # in standard deviations of what the noise and the bends of the misfit make where nothing jumps
MAD_TO_SD = 1.4826
SIGNAL = {"force": "force_N", "conductance": "conductance_S"}


def slips(signals: Signals, residual: Signals, dt_s: float) -> list[tuple[float, float]]:
    """Moments at which the knit seems to have slipped [s], and by how much (as strain), the largest slip first.

    Straight lines are fitted to the misfit just before and just after each sample; where they do not meet, something
    jumped. A slip comes on the way out, and lowers force and conductance as releasing the knit by that much would:
    how well one length explains the jumps of all channels tells it from a jump of the misfit, which is large where
    the sensor is steep and asks for hardly any length there.

    Parameters
    ----------
    signals : mapping of str to ndarray, each shape (n,)
        ``time_s``, ``strain``, and what the model makes of them: ``force_N``, ``conductance_S``.
    residual : mapping of str to ndarray, each shape (n,)
        Measured minus modelled: ``force`` in N, ``conductance`` in ln S.
    """
    steepness = _steepness(signals, residual.keys(), dt_s)
    jump = {channel: jumps(values, dt_s) for channel, values in residual.items()}
    usual = {channel: _usual(residual[channel], jump[channel], dt_s) for channel in residual}
    steep = np.array([steepness[channel] / usual[channel] for channel in residual])
    jumped = np.array([jump[channel] / usual[channel] for channel in residual])
    information = np.maximum(np.sum(steep**2, axis=0), 1e-300)
    slip = -np.sum(steep * jumped, axis=0) / information
    explained = slip**2 * information
    left = np.sum(jumped**2, axis=0) - explained
    strain = signals["strain"]
    # A grip gives way where the knit pulls, not where it hangs loose.
    pulled = (np.gradient(strain) > 0) & (strain > np.quantile(strain, PULLED))
    clear = pulled & (slip > 0) & (explained - left > LEAST**2)
    found = _peaks(np.where(clear, slip, 0.0), dt_s)
    return [(float(signals["time_s"][i]), float(slip[i])) for i in found]


def _steepness(signals: Signals, channels: Iterable[str], dt_s: float) -> dict[str, FloatArray]:
    """Change of force [N] and of ln G by unit of strain in the motion at each sample, each shape (n,)."""
    half = int(WINDOW_S / dt_s)
    at = np.arange(len(signals["strain"]))
    before, after = np.maximum(at - half, 0), np.minimum(at + half, len(at) - 1)
    moved = signals["strain"][after] - signals["strain"][before]
    moved = np.where(np.abs(moved) < LEAST_MOTION, LEAST_MOTION, moved)
    modelled = {c: np.log(signals[SIGNAL[c]]) if c == "conductance" else signals[SIGNAL[c]] for c in channels}
    return {channel: (values[after] - values[before]) / moved for channel, values in modelled.items()}


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


def _peaks(size: FloatArray, dt_s: float) -> list[int]:
    """Indices of the largest sizes above 0, apart from each other, largest first."""
    left, apart = size.copy(), int(APART_S / dt_s)
    found: list[int] = []
    while np.max(left) > 0:
        at = int(np.argmax(left))
        found.append(at)
        left[max(at - apart, 0) : at + apart] = 0
    return found
