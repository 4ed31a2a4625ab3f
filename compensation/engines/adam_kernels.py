"""One epoch of minibatch Adam on a small relu network, compiled.

scikit-learn spends most of its time between NumPy calls on 200 x 7 arrays; here one call runs a whole epoch. Arrays
are laid out (layer, unit, row of the batch), so that the inner loop runs over rows and becomes vector instructions.
Products are taken in tiles of 4 x 4 units: each row loaded serves four multiply-adds, where one unit at a time spends
its time on loads and stores. BLAS, made for larger matrices, is about half as fast at these widths.

All compiled code is in this one file: numba's cache notices a change in the file of the function called, no other.
"""

from __future__ import annotations

import numba
import numpy as np

# Sums may be reordered, nothing else: the results differ from the reference by rounding. NumPy's division, because a
# check for zero keeps Adam's step from becoming vector instructions.
jit = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})

BETA_1, BETA_2, EPSILON = 0.9, 0.999, 1e-8
TILE = 4


@jit
def epoch(features, target, order, widths, flat, first, second, steps, l2, batch, rate):
    """Step `flat` (weights), `first` and `second` (moments) in place; return loss summed over rows, steps so far."""
    layers = len(widths) - 1
    active = np.zeros((layers + 1, widths.max(), batch))
    delta = np.zeros((layers + 1, widths.max(), batch))
    gradient = np.zeros(len(flat))
    total = 0.0
    for begin in range(0, len(order), batch):
        rows = order[begin : begin + batch]
        count = len(rows)
        for unit in range(widths[0]):
            for k in range(count):
                active[0, unit, k] = features[rows[k], unit]
        _forward(widths, flat, active, count)
        loss = 0.0
        for k in range(count):
            error = active[layers, 0, k] - target[rows[k]]
            delta[layers, 0, k] = error
            loss += error * error
        _backward(widths, flat, active, delta, gradient, count)
        penalty = _finish_gradient(widths, flat, gradient, l2, count)
        total += 0.5 * loss + 0.5 * l2 * penalty
        steps += 1
        _adam_step(flat, gradient, first, second, steps, rate)
    return total, steps


@jit
def _forward(widths, flat, active, count):
    layers = len(widths) - 1
    at = 0
    for layer in range(layers):
        n_in, n_out = widths[layer], widths[layer + 1]
        out = active[layer + 1]
        for j in range(n_out):
            out[j, :count] = flat[at + n_in * n_out + j]
        add_products(flat, at, n_out, 1, active[layer], n_in, out, n_out, count)
        if layer < layers - 1:
            for j in range(n_out):
                for k in range(count):
                    out[j, k] = max(out[j, k], 0.0)
        at += (n_in + 1) * n_out


@jit
def _backward(widths, flat, active, delta, gradient, count):
    end = len(flat)
    for layer in range(len(widths) - 2, -1, -1):
        n_in, n_out = widths[layer], widths[layer + 1]
        at = end - (n_in + 1) * n_out
        values, step = active[layer], delta[layer + 1]
        for j in range(n_out):
            gradient[end - n_out + j] = step[j, :count].sum()
        correlate(gradient, at, values, n_in, step, n_out, count)
        if layer > 0:
            back = delta[layer]
            back[:n_in, :count] = 0.0
            add_products(flat, at, 1, n_out, step, n_out, back, n_in, count)
            for i in range(n_in):
                for k in range(count):
                    back[i, k] = back[i, k] if values[i, k] > 0.0 else 0.0
        end = at


@jit
def add_products(flat, at, down, across, values, n_in, out, n_out, count):
    """out[j] += sum over i of w[i, j] values[i]; w[i, j] is flat[at + i down + j across]."""
    tiled_in, tiled_out = n_in // TILE * TILE, n_out // TILE * TILE
    for j in range(0, tiled_out, TILE):
        for i in range(0, tiled_in, TILE):
            # Values are a, b, c, d and outputs e, f, g, h; `ae` is the weight from a to e.
            p = at + i * down + j * across
            ae, af, ag, ah = flat[p], flat[p + across], flat[p + 2 * across], flat[p + 3 * across]
            p += down
            be, bf, bg, bh = flat[p], flat[p + across], flat[p + 2 * across], flat[p + 3 * across]
            p += down
            ce, cf, cg, ch = flat[p], flat[p + across], flat[p + 2 * across], flat[p + 3 * across]
            p += down
            de, df, dg, dh = flat[p], flat[p + across], flat[p + 2 * across], flat[p + 3 * across]
            for k in range(count):
                a, b, c, d = values[i, k], values[i + 1, k], values[i + 2, k], values[i + 3, k]
                out[j, k] += ae * a + be * b + ce * c + de * d
                out[j + 1, k] += af * a + bf * b + cf * c + df * d
                out[j + 2, k] += ag * a + bg * b + cg * c + dg * d
                out[j + 3, k] += ah * a + bh * b + ch * c + dh * d
    for j in range(n_out):
        for i in range(tiled_in if j < tiled_out else 0, n_in):
            weight = flat[at + i * down + j * across]
            for k in range(count):
                out[j, k] += weight * values[i, k]


@jit
def correlate(gradient, at, values, n_in, step, n_out, count):
    """gradient[at + i n_out + j] = sum over rows of values[i] step[j]."""
    tiled_in, tiled_out = n_in // TILE * TILE, n_out // TILE * TILE
    for i in range(0, tiled_in, TILE):
        for j in range(0, tiled_out, TILE):
            ae = af = ag = ah = be = bf = bg = bh = ce = cf = cg = ch = de = df = dg = dh = 0.0
            for k in range(count):
                a, b, c, d = values[i, k], values[i + 1, k], values[i + 2, k], values[i + 3, k]
                e, f, g, h = step[j, k], step[j + 1, k], step[j + 2, k], step[j + 3, k]
                ae, af, ag, ah = ae + a * e, af + a * f, ag + a * g, ah + a * h
                be, bf, bg, bh = be + b * e, bf + b * f, bg + b * g, bh + b * h
                ce, cf, cg, ch = ce + c * e, cf + c * f, cg + c * g, ch + c * h
                de, df, dg, dh = de + d * e, df + d * f, dg + d * g, dh + d * h
            p = at + i * n_out + j
            gradient[p], gradient[p + 1], gradient[p + 2], gradient[p + 3] = ae, af, ag, ah
            p += n_out
            gradient[p], gradient[p + 1], gradient[p + 2], gradient[p + 3] = be, bf, bg, bh
            p += n_out
            gradient[p], gradient[p + 1], gradient[p + 2], gradient[p + 3] = ce, cf, cg, ch
            p += n_out
            gradient[p], gradient[p + 1], gradient[p + 2], gradient[p + 3] = de, df, dg, dh
    for i in range(n_in):
        for j in range(tiled_out if i < tiled_in else 0, n_out):
            product = 0.0
            for k in range(count):
                product += values[i, k] * step[j, k]
            gradient[at + i * n_out + j] = product


@jit
def _finish_gradient(widths, flat, gradient, l2, count):
    penalty = 0.0
    at = 0
    for layer in range(len(widths) - 1):
        weights = widths[layer] * widths[layer + 1]
        for k in range(at, at + weights):
            penalty += flat[k] * flat[k]
            gradient[k] += l2 * flat[k]
        at += weights + widths[layer + 1]
    for k in range(len(gradient)):
        gradient[k] /= count
    return penalty


@jit
def _adam_step(flat, gradient, first, second, steps, rate):
    step = rate * np.sqrt(1 - BETA_2**steps) / (1 - BETA_1**steps)
    for k in range(len(flat)):
        first[k] = BETA_1 * first[k] + (1 - BETA_1) * gradient[k]
        second[k] = BETA_2 * second[k] + (1 - BETA_2) * gradient[k] * gradient[k]
        flat[k] -= step * first[k] / (np.sqrt(second[k]) + EPSILON)
