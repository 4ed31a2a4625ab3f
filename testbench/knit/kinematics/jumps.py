"""Moments at which the misfit jumps: a slipping clamp shows itself by them, a permanent set has none."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import FloatArray, Signals, step_s

BESIDE_S = 0.3  # long enough to average the noise, short enough that the misfit runs straight
SKIP_S = 0.05  # around the jump itself, which the averaging of samples blurs
JUMPS_APART_S = 1.0
PULLED = 0.25  # quantile of the strain above which a grip may give way
STRAIN_BINS = 20  # over which force and ln G are averaged to see how steep the sensor is
STIFFER_BACK = (1.0, 2.0, 4.0)  # friction makes the force drop so many times faster on the first way back
LEAST = 5.0  # in standard deviations of what the noise and the bends of the misfit make where nothing jumps
MAD_TO_SD = 1.4826
SIGNAL = {"force": "force_N", "conductance": "conductance_S"}


def slips(signals: Signals, residual: Signals) -> list[tuple[float, float]]:
    """Moments at which the knit seems to have slipped [s], and by how much (as strain), the largest slip first.

    Straight lines are fitted to the misfit just before and just after each sample; where they do not meet, something
    jumped. A slip lowers force and conductance as releasing the knit by that much would: how well one length explains
    the jumps of all channels tells it from a jump of the misfit. It may come on the way out, on the way back or in a
    hold, since a grip may give way a while after the load has come.

    Parameters
    ----------
    signals : mapping of str to ndarray, each shape (n,)
        ``time_s``, ``strain``, and what the model makes of them: ``force_N``, ``conductance_S``.
    residual : mapping of str to ndarray, each shape (n,)
        Measured minus modelled: ``force`` in N, ``conductance`` in ln S.

    Returns
    -------
    list of tuple of float
        Time of the slip in s, and how much longer the knit became, as strain.
    """
    if not residual:
        return []
    strain, dt_s = signals["strain"], step_s(signals)
    jump = {channel: jumps(values, dt_s) for channel, values in residual.items()}
    usual = {channel: _usual(residual[channel], jump[channel], dt_s) for channel in residual}
    steep = {channel: steepness(strain, signals[SIGNAL[channel]], channel) / usual[channel] for channel in residual}
    jumped = np.array([jump[channel] / usual[channel] for channel in residual])
    slip, clear = np.zeros(len(strain)), np.full(len(strain), LEAST**2)
    for stiffer in STIFFER_BACK if len(steep) > 1 else (1.0,):
        rows = np.array([steep[c] * (stiffer if c == "force" else 1.0) for c in residual])
        information = np.maximum(np.sum(rows**2, axis=0), 1e-300)
        length = -np.sum(rows * jumped, axis=0) / information
        explained = length**2 * information
        clearly = 2 * explained - np.sum(jumped**2, axis=0)
        better = clearly > clear
        slip[better], clear[better] = length[better], clearly[better]
    # A grip gives way where the knit pulls, not where it hangs loose.
    found = _peaks(np.where(strain > np.quantile(strain, PULLED), slip, 0.0), dt_s)
    return [(float(signals["time_s"][i]), float(slip[i])) for i in found]


def steepness(strain: FloatArray, values: FloatArray, channel: str) -> FloatArray:
    """Mean change of force [N] or ln G by unit of strain at the strain of each sample, shape (n,)."""
    values = np.log(values) if channel == "conductance" else values
    edges = np.linspace(np.min(strain), np.max(strain), STRAIN_BINS + 1)
    bins = np.clip(np.digitize(strain, edges) - 1, 0, STRAIN_BINS - 1)
    count = np.bincount(bins, minlength=STRAIN_BINS)
    seen = np.flatnonzero(count)
    if len(seen) < 2:
        return np.zeros_like(strain)
    level = np.bincount(bins, values, STRAIN_BINS)[seen] / count[seen]
    middle = 0.5 * (edges[:-1] + edges[1:])[seen]
    return np.interp(strain, middle, np.gradient(level, middle))


def jumps(x: FloatArray, dt_s: float) -> FloatArray:
    """Jump at each sample, shape (n,): a straight line through what follows minus one through what came before."""
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
    return max(int(BESIDE_S / dt_s), 6), max(round(SKIP_S / dt_s), 1)


def _usual(x: FloatArray, jump: FloatArray, dt_s: float) -> float:
    """Standard deviation of `jump` where nothing jumps: what the noise makes, and what lines miss in this misfit."""
    count, _ = _lengths(dt_s)
    noise = MAD_TO_SD * float(np.median(np.abs(np.diff(x, 2)))) / np.sqrt(6)
    return max(noise * np.sqrt(8 / count), MAD_TO_SD * float(np.median(np.abs(jump))), 1e-300)


def _peaks(size: FloatArray, dt_s: float) -> list[int]:
    """Indices of the largest sizes above 0, apart from each other, largest first."""
    free, apart = size > 0, max(int(JUMPS_APART_S / dt_s), 1)
    found: list[int] = []
    for at in np.argsort(-size, kind="stable")[: int(free.sum())]:
        if free[at]:
            found.append(int(at))
            free[max(at - apart, 0) : at + apart] = False
    return found
