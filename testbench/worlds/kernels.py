"""Sequential operators on samples at any instants, compiled: the time step may change from sample to sample.

Written apart from `testbench.knit.kernels` on purpose: the worlds must not share code with what they judge.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from gcode.support.arrays import FloatArray


@njit("float64[:](float64[:], float64[:], float64, float64)", cache=True, nogil=True)
def lowpass_two_way(t: FloatArray, x: FloatArray, tau_up: float, tau_down: float) -> FloatArray:
    """Answer of ``tau y' = x - y`` to `x` joined by straight lines, at rest before (``y[0] = x[0]``).

    `tau` is one where it rises and another where it falls; exact but for the steps in which the way changes.
    """
    y = np.empty_like(x)
    y[0] = x[0]
    for i in range(1, len(x)):
        h = (t[i] - t[i - 1]) / (tau_up if x[i] + x[i - 1] > 2 * y[i - 1] else tau_down)
        slope = (x[i] - x[i - 1]) / h
        y[i] = x[i] - slope + (y[i - 1] - x[i - 1] + slope) * np.exp(-h)
    return y


@njit("float64[:](float64[:], float64[:], float64)", cache=True, nogil=True)
def lowpass(t: FloatArray, x: FloatArray, tau: float) -> FloatArray:
    """The same with one time constant, exact."""
    return lowpass_two_way(t, x, tau, tau)


@njit("float64[:](float64[:], float64)", cache=True, nogil=True)
def stop(x: FloatArray, width: float) -> FloatArray:
    """Elastic-plastic (Jenkin) element: follows `x` and slips at +-`width`."""
    s = np.empty_like(x)
    s[0] = 0.0
    for i in range(1, len(x)):
        s[i] = min(max(s[i - 1] + x[i] - x[i - 1], -width), width)
    return s


@njit("float64[:](float64[:], float64, float64, float64)", cache=True, nogil=True)
def bouc_wen(x: FloatArray, reach: float, asymmetry: float, power: float) -> FloatArray:
    """Bouc-Wen hysteretic variable, scaled to +-1.

    ``reach dz = dx (1 - |z|^power (0.5 + asymmetry + (0.5 - asymmetry) sign(dx z)))``, in 4 sub-steps a sample.
    Source: Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249.
    """
    z = np.empty_like(x)
    z[0] = 0.0
    state = 0.0
    for i in range(1, len(x)):
        dx = (x[i] - x[i - 1]) / 4
        for _ in range(4):
            side = 1.0 if dx * state >= 0 else -1.0
            pull = abs(state) ** power * (0.5 + asymmetry + (0.5 - asymmetry) * side)
            state += dx / reach * (1.0 - pull)
            state = min(max(state, -1.0), 1.0)
        z[i] = state
    return z


@njit("float64[:](float64[:], float64[:], float64, float64)", cache=True, nogil=True)
def oscillator(t: FloatArray, x: FloatArray, frequency_hz: float, damping: float) -> FloatArray:
    """Damped oscillator of unit static gain, exact for `x` held at the mean of each two samples between them.

    It swings about what is held as the real part of a number that turns and shrinks in the complex plane.
    """
    y = np.empty_like(x)
    own = np.sqrt(1 - damping * damping)
    pole = 2 * np.pi * frequency_hz * complex(-damping, own)
    kick = complex(1.0, -damping / own)  # for a swing that begins at rest
    held, swing = x[0], complex(0.0, 0.0)
    y[0] = held
    for i in range(1, len(x)):
        before, held = held, 0.5 * (x[i] + x[i - 1])
        swing = (swing + (before - held) * kick) * np.exp(pole * (t[i] - t[i - 1]))
        y[i] = held + swing.real
    return y


@njit("float64[:](float64[:], float64, float64, float64)", cache=True, nogil=True)
def relay(x: FloatArray, low: float, high: float, start: float) -> FloatArray:
    """Schmitt trigger: becomes 1 above `high`, 0 below `low`."""
    state = start
    out = np.empty_like(x)
    for i in range(len(x)):
        if x[i] > high:
            state = 1.0
        elif x[i] < low:
            state = 0.0
        out[i] = state
    return out


@njit("float64[:](float64[:], float64)", cache=True, nogil=True)
def last_turning_point(x: FloatArray, least: float) -> FloatArray:
    """Index of the last reversal (by more than `least`) before each sample; 0 before the first."""
    out = np.empty_like(x)
    direction, extreme, at, turned = 0.0, x[0], 0, 0
    for i in range(len(x)):
        ahead = (x[i] - extreme) * direction
        if direction == 0.0:
            if abs(x[i] - extreme) > least:
                direction = 1.0 if x[i] > extreme else -1.0
                extreme, at = x[i], i
        elif ahead >= 0:
            extreme, at = x[i], i
        elif -ahead > least:
            turned = at
            direction = -direction
            extreme, at = x[i], i
        out[i] = turned
    return out


@njit("float64[:](float64[:], float64[:], float64[:], float64)", cache=True, nogil=True)
def ratchet_slips(force: FloatArray, thresholds: FloatArray, jumps: FloatArray, rearm: float) -> FloatArray:
    """Sum of slips so far: the next jump comes above the next threshold, once `rearm` was passed downwards."""
    out = np.empty_like(force)
    total, k, armed = 0.0, 0, True
    for i in range(len(force)):
        if not armed and force[i] < rearm:
            armed = True
        if armed and k < len(jumps) and force[i] > thresholds[k]:
            total += jumps[k]
            k += 1
            armed = False
        out[i] = total
    return out


@njit("float64[:](float64[:], float64[:], float64)", cache=True, nogil=True)
def seconds_near(t: FloatArray, x: FloatArray, width: float) -> FloatArray:
    """How long `x` has stayed within `width` of where it last settled [s]."""
    out = np.empty_like(x)
    anchor, since = x[0], t[0]
    for i in range(len(x)):
        while abs(x[i] - anchor) > width:
            anchor += width if x[i] > anchor else -width
            since = t[i]
        out[i] = t[i] - since
    return out
