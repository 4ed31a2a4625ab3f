"""What a knit can remember: the operators that a proposed law is made of.

Each takes a whole signal and returns a whole signal of shape (n,), started at rest; none looks ahead. Linear memory
lies in `testbench.knit.filters`, play operators and running maxima in `testbench.knit.kernels`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from testbench.knit import spectra
from testbench.knit.effect import FloatArray
from testbench.knit.filters import hold_coefficients, memory
from testbench.knit.filters import moving as moving
from testbench.knit.kernels import bouc_wen_of_exponent_1, last_turn, play, travelled, turns
from testbench.knit.lags import two_way_lowpass

BACK = 0.02  # of the span: a turn is known once the strain has come back so far
BROAD = 7  # lags of a memory over decades
WIGGLE = 0.005  # of the span: motion below this wears nothing


@njit("float64[:](float64[:], float64[:], float64)", cache=True, nogil=True)
def kinetics(gain_per_s: FloatArray, loss_per_s: FloatArray, dt_s: float) -> FloatArray:
    """Share n in 0..1 with ``dn/dt = gain (1 - n) - loss n``, in equilibrium at the start.

    Exact for rates that stand still at their mean over each step, however quick they are.

    Parameters
    ----------
    gain_per_s, loss_per_s : ndarray, shape (n,)
        Not negative, in 1/s. Where both are zero at the start, n starts at zero.
    """
    out = np.empty_like(gain_per_s)
    total = gain_per_s[0] + loss_per_s[0]
    n = gain_per_s[0] / total if total > 0.0 else 0.0
    out[0] = n
    for i in range(1, len(out)):
        gain = 0.5 * (gain_per_s[i - 1] + gain_per_s[i])
        total = gain + 0.5 * (loss_per_s[i - 1] + loss_per_s[i])
        if total > 0.0:
            level = gain / total
            n = level + (n - level) * math.exp(-total * dt_s)
        out[i] = n
    return out


@njit("float64[:](float64[:], float64[:], float64)", cache=True, nogil=True)
def gathered(gain: FloatArray, loss_per_s: FloatArray, dt_s: float) -> FloatArray:
    """A store that fills and empties, ``dn/dt = gain - loss n``, without a limit; empty at the start.

    Exact for rates that stand still at their mean over each step.
    """
    out = np.empty_like(gain)
    n = 0.0
    out[0] = n
    for i in range(1, len(out)):
        loss = 0.5 * (loss_per_s[i - 1] + loss_per_s[i]) * dt_s
        stays = -math.expm1(-loss) / loss if loss > 1e-9 else 1.0
        n = n * math.exp(-loss) + 0.5 * (gain[i - 1] + gain[i]) * dt_s * stays
        out[i] = n
    return out


@njit("float64[:](float64[:], float64, float64, float64)", cache=True, nogil=True)
def oscillator(x: FloatArray, frequency_hz: float, damping: float, dt_s: float) -> FloatArray:
    """Oscillator of unit gain at rest, driven by `x`: exact for `x` held at its mean over a step; damping < 1."""
    out = np.empty_like(x)
    w = 2.0 * math.pi * frequency_hz
    wd = w * math.sqrt(max(1.0 - damping * damping, 1e-6))
    decay = math.exp(-damping * w * dt_s)
    c, s = math.cos(wd * dt_s), math.sin(wd * dt_s)
    position, velocity = x[0], 0.0
    out[0] = position
    for i in range(1, len(x)):
        held = 0.5 * (x[i] + x[i - 1])
        u = position - held
        position = held + decay * (u * (c + damping * w / wd * s) + velocity / wd * s)
        velocity = decay * (velocity * (c - damping * w / wd * s) - u * w * w / wd * s)
        out[i] = position
    return out


@njit("float64[:](float64[:], float64, float64)", cache=True, nogil=True)
def relay(x: FloatArray, on_above: float, off_below: float) -> FloatArray:
    """1 from where `x` rises above one level until it falls below the other, else 0 (Preisach's relay)."""
    out = np.empty_like(x)
    state = 1.0 if x[0] > on_above else 0.0
    for i in range(len(x)):
        if x[i] > on_above:
            state = 1.0
        elif x[i] < off_below:
            state = 0.0
        out[i] = state
    return out


@njit("float64[:](float64[:], float64, float64)", cache=True, nogil=True)
def no_quicker(x: FloatArray, most_per_s: float, dt_s: float) -> FloatArray:
    """`x` as it is shown by what moves by so much in a second at most: a slew rate."""
    out = np.empty_like(x)
    shown, most = x[0], most_per_s * dt_s
    for i in range(len(x)):
        shown += min(max(x[i] - shown, -most), most)
        out[i] = shown
    return out


@njit("float64[:](float64[:], float64)", cache=True, nogil=True)
def held(x: FloatArray, width: float) -> FloatArray:
    """A reading with a dead band: it stays until `x` is farther from it than `width`.

    Its new value is `x` at that very moment, between the samples.
    """
    out = np.empty_like(x)
    shown = x[0]
    for i in range(len(x)):
        off = x[i] - shown
        if abs(off) > width > 0.0:
            shown += width * (math.floor(off / width) if off > 0.0 else math.ceil(off / width))
        elif width <= 0.0:
            shown = x[i]
        out[i] = shown
    return out


def stuck(x: FloatArray, grip: float) -> FloatArray:
    """How far `x` has gone since it last stuck; it lets go, and sticks anew, beyond `grip` either way."""
    return x - held(np.ascontiguousarray(x), grip)


@njit("float64[:](float64[:], float64, float64)", cache=True, nogil=True)
def seconds_near(x: FloatArray, width: float, dt_s: float) -> FloatArray:
    """For how many seconds `x` has stayed within `width` of where it settled.

    It settles anew in steps of `width`, at the moment between the samples when it gets there: what has just moved on
    stands in the middle of its window, not at its edge.
    """
    out = np.empty_like(x)
    anchor, since = x[0], 0.0
    for i in range(len(x)):
        off = x[i] - anchor
        if abs(off) > width > 0.0:
            anchor += width * (math.floor(off / width) if off > 0.0 else math.ceil(off / width))
            since = i - (x[i] - anchor) / (x[i] - x[i - 1])
        out[i] = (i - since) * dt_s
    return out


def upper_turn(x: FloatArray, back: float) -> FloatArray:
    """Where `x` last turned downwards, known once it has come back by `back`; its start before that."""
    turned = last_turn(x, back)
    return x[np.maximum.accumulate(np.where(x < x[turned], turned, 0))]


def swung(x: FloatArray, back: float) -> FloatArray:
    """Summed size of the completed swings of `x`: one is complete once `x` has come back by `back`."""
    return np.cumsum(np.abs(np.diff(x[last_turn(x, back)], prepend=x[0])))


def turning(x: FloatArray, back: float, dt_s: float) -> FloatArray:
    """Size of the swing that is over at each turn of `x`, over the time of the step in which the turn is known."""
    return np.diff(swung(x, back), prepend=0.0) / dt_s


def heading(x: FloatArray, span: float) -> FloatArray:
    """+1 while `x` goes up, -1 while it comes down, turning over within `BACK` of the span."""
    return bouc_wen_of_exponent_1(np.ascontiguousarray(x), BACK * span, 0.5)


def since_turn(x: FloatArray, span: float, dt_s: float) -> FloatArray:
    """Seconds since `x` last turned by more than `BACK` of the span."""
    return (np.arange(len(x)) - last_turn(x, BACK * span)) * dt_s


def turns_so_far(x: FloatArray, span: float) -> FloatArray:
    """How often `x` has turned by more than `BACK` of the span."""
    return turns(np.ascontiguousarray(x), BACK * span)[2]


def last_top(x: FloatArray, back: float) -> FloatArray:
    """Where `x` last turned downwards, or where it is once it has passed that: beyond, the old top is forgotten."""
    return np.maximum(upper_turn(x, back), x)


def largest(x: FloatArray) -> FloatArray:
    """Largest value so far."""
    return np.maximum.accumulate(x)


def path(x: FloatArray, span: float) -> FloatArray:
    """Path of `x` so far, without its wiggles."""
    return travelled(np.ascontiguousarray(x), WIGGLE * span)


def work(force_N: FloatArray, strain: FloatArray) -> FloatArray:
    """Work done so far, back and forth, over the gauge length, in N: integral of \\|F de\\|."""
    middle = 0.5 * np.abs(force_N[1:] + force_N[:-1])
    return np.concatenate([np.zeros(1), np.cumsum(middle * np.abs(np.diff(strain)))])


def delayed(x: FloatArray, delay_s: float, dt_s: float) -> FloatArray:
    """`x` as it was `delay_s` ago; its first value before that."""
    at = np.arange(len(x)) - delay_s / dt_s
    return np.interp(at, np.arange(len(x)), x)


def ever_later(x: FloatArray, skew: float) -> FloatArray:
    """`x` as an instrument shows it whose clock is slow by a share `skew`: the later, the longer it has run.

    A negative `skew` is a clock that is fast. What it has shown last stays where the motion ends before it does.
    """
    at = np.arange(len(x), dtype=np.float64)
    return np.interp(at * (1.0 - skew), at, x)


def broad_memory(x: FloatArray, tau_s: float, decades: float, dt_s: float) -> FloatArray:
    """Mean of first-order lags whose times are spread evenly in ln over so many decades around `tau_s`.

    Polymers relax over decades: within the spread a step is remembered as the logarithm of time.

    Source: box spectrum, Tschoegl, The Phenomenological Theory of Linear Viscoelastic Behavior (1989), ch. 6.
    """
    half = 10.0 ** (0.5 * decades)
    return x[0] + memory(x, *spectra.box(tau_s / half, tau_s * half, BROAD), dt_s)


def two_way_lag(x: FloatArray, up_s: float, down_s: float, dt_s: float) -> FloatArray:
    """Lag with one time while it rises and another while it falls, at rest at the start; shape (n,).

    Exact for `x` that runs straight between its samples, but for the step in which the way changes.
    """
    up, down = (np.concatenate(hold_coefficients(np.array([tau_s]), dt_s)) for tau_s in (up_s, down_s))
    return two_way_lowpass(np.ascontiguousarray(x), up, down)


def stop(x: FloatArray, reach: float) -> FloatArray:
    """What a slip element of this reach carries, -reach to reach: `x` less its play."""
    return x - play(np.ascontiguousarray(x), np.array([reach]))[0]


@njit("float64[:](float64[:], float64, float64, float64)", cache=True, nogil=True)
def relaxing_stop(x: FloatArray, reach: float, tau_s: float, dt_s: float) -> FloatArray:
    """What a slip element in series with a dashpot carries: ``dh/dt = dx/dt - h / tau``, never beyond the reach.

    Exact for `x` that runs straight between its samples, but for the step in which it begins to slip.
    """
    out = np.empty_like(x)
    keep = math.exp(-dt_s / tau_s)
    passes = (1.0 - keep) * tau_s / dt_s
    h = 0.0
    out[0] = h
    for i in range(1, len(x)):
        h = min(max(h * keep + (x[i] - x[i - 1]) * passes, -reach), reach)
        out[i] = h
    return out


def power_of(x: FloatArray, exponent: float) -> FloatArray:
    """A power that keeps the sign."""
    return np.sign(x) * np.abs(x) ** exponent


def over(x: FloatArray, edge: float) -> FloatArray:
    """How far `x` lies above an edge, else 0."""
    return np.maximum(x - edge, 0.0)


def bump(x: FloatArray, centre: float, width: float) -> FloatArray:
    """A bell of height 1 at `centre`."""
    return np.exp(-0.5 * np.minimum(((x - centre) / width) ** 2, 1400.0))
