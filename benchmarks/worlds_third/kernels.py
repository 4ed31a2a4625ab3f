"""Loops over samples that no array formula does: memories of time, of distance, and of turning points."""

from __future__ import annotations

import numpy as np
from numba import njit

from worlds_third.signals import Array


@njit(cache=True)
def follow(target: Array, step_s: Array, rise_s: float, fall_s: float, start: float) -> Array:
    """First-order follower: ``dq/dt = (target - q)/tau``, with a time of its own for rising and for falling."""
    out = np.empty_like(target)
    q = start
    for k in range(len(target)):
        tau = rise_s if target[k] > q else fall_s
        q += (target[k] - q) * (1.0 - np.exp(-step_s[k] / tau))
        out[k] = q
    return out


@njit(cache=True)
def follow_activated(target: Array, step_s: Array, tau_s: float, steepness: float) -> Array:
    """Follower that flows as Eyring's: ``dq/dt = sinh(b (target - q))/(b tau)``, in steps that cannot overshoot."""
    out = np.empty_like(target)
    q = 0.0
    for k in range(len(target)):
        gap = target[k] - q
        if abs(gap) > 1e-12:
            speed = np.sinh(min(steepness * abs(gap), 30.0)) / (steepness * tau_s * abs(gap))
            q += gap * (1.0 - np.exp(-step_s[k] * speed))
        out[k] = q
    return out


@njit(cache=True)
def direction(x: Array, reach: float) -> Array:
    """Smooth sign of motion: goes to +1 or -1 over a distance `reach` after a turn, stays in a hold."""
    out = np.zeros_like(x)
    s = 0.0
    for k in range(1, len(x)):
        dx = x[k] - x[k - 1]
        s += (np.sign(dx) - s) * (1.0 - np.exp(-abs(dx) / reach))
        out[k] = s
    return out


@njit(cache=True)
def trail(x: Array, reach: float) -> Array:
    """Follower in distance: ``dq = (x - q) |dx| / reach``."""
    out = np.empty_like(x)
    q = x[0]
    out[0] = q
    for k in range(1, len(x)):
        q += (x[k] - q) * (1.0 - np.exp(-abs(x[k] - x[k - 1]) / reach))
        out[k] = q
    return out


@njit(cache=True)
def play(x: Array, half_width: float) -> Array:
    """Dead band of both directions: the follower moves only when pushed by an end of the gap."""
    out = np.empty_like(x)
    q = x[0]
    for k in range(len(x)):
        q = min(max(q, x[k] - half_width), x[k] + half_width)
        out[k] = q
    return out


@njit(cache=True)
def slip_elements(x: Array, reaches: Array, weights: Array) -> Array:
    """Maxwell-slip elements side by side: each a spring that slides at +-1, weighted."""
    out = np.zeros_like(x)
    z = np.zeros(len(reaches))
    for k in range(1, len(x)):
        dx = x[k] - x[k - 1]
        total = 0.0
        for i in range(len(reaches)):
            z[i] = min(max(z[i] + dx / reaches[i], -1.0), 1.0)
            total += weights[i] * z[i]
        out[k] = total
    return out


@njit(cache=True)
def bristles(x: Array, step_s: Array, reach: float, excess: float, stribeck: float) -> Array:
    """LuGre's mean bristle over its sliding value; it slides at 1 when fast, at 1 + excess when slow."""
    out = np.zeros_like(x)
    z = 0.0
    for k in range(1, len(x)):
        dx = x[k] - x[k - 1]
        speed = abs(dx) / max(step_s[k], 1e-9)
        top = 1.0 + excess * np.exp(-((speed / stribeck) ** 2))
        z += (np.sign(dx) * top - z) * (1.0 - np.exp(-abs(dx) / (reach * top)))
        out[k] = z
    return out


@njit(cache=True)
def bouc_wen(x: Array, reach: float, beta: float, power: float) -> Array:
    """``dz = (dx - beta |dx| |z|^(n-1) z - (1 - beta) dx |z|^n) / reach``, so that |z| stays below 1."""
    out = np.zeros_like(x)
    z = 0.0
    for k in range(1, len(x)):
        dx = x[k] - x[k - 1]
        parts = int(abs(dx) / (0.2 * reach)) + 1
        for _ in range(parts):
            d = dx / parts / reach
            size = abs(z) ** power
            z += d - beta * abs(d) * size * np.sign(z) - (1.0 - beta) * d * size
            z = min(max(z, -1.0), 1.0)
        out[k] = z
    return out


@njit(cache=True)
def masing(x: Array, reach: float) -> Array:
    """Loops of one backbone u/(1 + |u|): doubled after each turn, closed at the turn before (Masing, Madelung)."""
    out = np.zeros_like(x)
    turn_x = np.zeros(len(x) + 2)
    turn_h = np.zeros(len(x) + 2)
    depth = 0  # number of turns remembered
    way = 0.0
    h = 0.0
    for k in range(1, len(x)):
        dx = x[k] - x[k - 1]
        if dx != 0.0:
            if way != 0.0 and np.sign(dx) != way:
                turn_x[depth], turn_h[depth] = x[k - 1], h
                depth += 1
            way = np.sign(dx)
            while depth > 1 and (x[k] - turn_x[depth - 2]) * way >= 0.0:
                depth -= 2
            if depth == 1 and abs(x[k] - x[0]) >= abs(turn_x[0] - x[0]) and (x[k] - x[0]) * (turn_x[0] - x[0]) < 0:
                depth = 0
            if depth == 0:
                u = (x[k] - x[0]) / reach
                h = u / (1.0 + abs(u))
            else:
                u = (x[k] - turn_x[depth - 1]) / (2.0 * reach)
                h = turn_h[depth - 1] + 2.0 * u / (1.0 + abs(u))
        out[k] = h
    return out


@njit(cache=True)
def relays(x: Array, closes: Array, opens: Array, weights: Array) -> Array:
    """Weighted sum of contacts that close above one strain and open below another, lower one (Preisach)."""
    out = np.empty_like(x)
    up, down = np.argsort(closes), np.argsort(opens)
    on = closes <= x[0]
    total = np.sum(weights[on])
    below, above = 0, len(opens)  # closes[up[:below]] are at or below x, opens[down[above:]] at or above
    for k in range(len(x)):
        while below < len(up) and closes[up[below]] <= x[k]:
            i = up[below]
            total += 0.0 if on[i] else weights[i]
            on[i] = True
            below += 1
        while below > 0 and closes[up[below - 1]] > x[k]:
            below -= 1
        while above > 0 and opens[down[above - 1]] >= x[k]:
            above -= 1
            i = down[above]
            total -= weights[i] if on[i] else 0.0
            on[i] = False
        while above < len(down) and opens[down[above]] < x[k]:
            above += 1
        out[k] = total
    return out


@njit(cache=True)
def approach(pace: Array) -> Array:
    """A quantity that goes from 0 to 1: ``dq = (1 - q) pace``, pace the dimensionless advance of each step."""
    return 1.0 - np.exp(-np.cumsum(pace))


@njit(cache=True)
def half_strokes(x: Array, smallest: float) -> Array:
    """Length of the half-stroke that ends at each turning point, 0 elsewhere; turns of less are not seen."""
    out = np.zeros_like(x)
    start, extreme, way = x[0], x[0], 0.0
    for k in range(1, len(x)):
        if way == 0.0:
            if abs(x[k] - start) > smallest:
                way = np.sign(x[k] - start)
                extreme = x[k]
        elif (x[k] - extreme) * way > 0.0:
            extreme = x[k]
        elif (extreme - x[k]) * way > smallest:
            out[k] = abs(extreme - start)
            start, extreme, way = extreme, x[k], -way
    return out


@njit(cache=True)
def ageing(x: Array, step_s: Array, reach: float) -> Array:
    """Age of frictional contacts in s (Dieterich): ``d theta = dt - theta |dx| / reach``."""
    out = np.empty_like(x)
    age = 1.0
    for k in range(len(x)):
        moved = abs(x[k] - x[k - 1]) / reach if k > 0 else 0.0
        if moved > 1e-12:
            settled = step_s[k] / moved
            age = settled + (age - settled) * np.exp(-moved)
        else:
            age += step_s[k]
        out[k] = age
    return out


@njit(cache=True)
def oscillator(push: Array, step_s: Array, frequency_hz: float, damping: float) -> Array:
    """Displacement of a damped pendulum under an acceleration, exact for a push constant over a step."""
    out = np.zeros_like(push)
    w = 2.0 * np.pi * frequency_hz
    wd = w * np.sqrt(1.0 - damping**2)
    y, v = 0.0, 0.0
    for k in range(1, len(push)):
        dt = step_s[k]
        rest = push[k] / w**2
        e, c, s = np.exp(-damping * w * dt), np.cos(wd * dt), np.sin(wd * dt)
        a = y - rest
        b = (v + damping * w * a) / wd
        y = rest + e * (a * c + b * s)
        v = e * ((b * wd - damping * w * a) * c - (a * wd + damping * w * b) * s)
        out[k] = y
    return out


@njit(cache=True)
def limited(y: Array, step_s: Array, fastest: float) -> Array:
    """A reading that cannot change faster than `fastest` a second."""
    out = np.empty_like(y)
    q = y[0]
    for k in range(len(y)):
        most = fastest * step_s[k]
        q += min(max(y[k] - q, -most), most)
        out[k] = q
    return out


@njit(cache=True)
def lazy_filter(y: Array, step_s: Array, slow_s: float, change: float) -> Array:
    """A filter of firmware that smooths small changes over `slow_s` and lets changes beyond `change` pass."""
    out = np.empty_like(y)
    q = y[0]
    for k in range(len(y)):
        gap = abs(y[k] - q) / change
        q += (y[k] - q) * (1.0 - np.exp(-step_s[k] * (1.0 + gap**2) / slow_s))
        out[k] = q
    return out


@njit(cache=True)
def zero_tracked(y: Array, step_s: Array, band: float, tau_s: float) -> Array:
    """A scale that takes small readings for an error of its zero, and takes them away slowly."""
    out = np.empty_like(y)
    zero = 0.0
    for k in range(len(y)):
        read = y[k] - zero
        if abs(read) < band:
            zero += read * (1.0 - np.exp(-step_s[k] / tau_s))
        out[k] = y[k] - zero
    return out
