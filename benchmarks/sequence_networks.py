"""Small recurrent and convolutional networks without a framework: rivals for `bench_compensators.py`.

Both map one standardised signal to one standardised target, sample by sample and causally, and are trained by Adam on
squared errors. Gradients are written out; `python benchmarks/sequence_networks.py` compares them with differences.

GRU: Cho et al., "Learning phrase representations using RNN encoder-decoder" (2014). TCN: Bai, Kolter and Koltun, "An
empirical evaluation of generic convolutional and recurrent networks for sequence modeling" (2018), two taps a layer.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gcode.support.arrays import FloatArray

# Parameters, inputs, truth, rows that count -> loss and its gradient.
Loss = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], tuple[float, FloatArray]]


def adam(loss: Loss, flat: FloatArray, lessons: Callable[[int], tuple], steps: int, rate: float) -> FloatArray:
    """Adam with a rate that falls to zero as a cosine; `lessons` gives inputs, truth and weights of each step."""
    first, second = np.zeros_like(flat), np.zeros_like(flat)
    for step in range(1, steps + 1):
        _, gradient = loss(flat, *lessons(step))
        gradient *= min(1.0, 1.0 / max(float(np.linalg.norm(gradient)), 1e-12))
        first += 0.1 * (gradient - first)
        second += 0.001 * (gradient**2 - second)
        now = 0.5 * rate * (1 + np.cos(np.pi * step / steps))
        flat = flat - now * (first / (1 - 0.9**step)) / (np.sqrt(second / (1 - 0.999**step)) + 1e-8)
    return flat


class Gru:
    """One gated recurrent layer and a linear output; inputs of shape (sequences, steps)."""

    def __init__(self, hidden: int) -> None:
        self.hidden = hidden

    @property
    def parameter_count(self) -> int:
        """Weights and biases."""
        return 3 * self.hidden * (self.hidden + 2) + self.hidden + 1

    def start(self, rng: np.random.Generator) -> FloatArray:
        """Random weights; update gates that begin by keeping."""
        flat = rng.standard_normal(self.parameter_count) / np.sqrt(self.hidden)
        weights, recurrent, bias, _, _ = self._parts(flat)
        bias[:] = 0.0
        bias[0] = np.linspace(0.0, 5.0, self.hidden)
        weights *= np.sqrt(self.hidden) * 0.5
        recurrent *= 0.7
        flat[-1] = 0.0
        return flat

    def _parts(self, flat: FloatArray) -> tuple[FloatArray, ...]:
        h = self.hidden
        ends = np.cumsum([3 * h, 3 * h * h, 3 * h, h, 1])
        w, u, b, v, c = np.split(flat, ends[:-1])
        return w.reshape(3, h), u.reshape(3, h, h), b.reshape(3, h), v, c

    def __call__(self, flat: FloatArray, x: FloatArray) -> FloatArray:
        """Output at every step."""
        return self._forward(flat, x)[0]

    def _forward(self, flat: FloatArray, x: FloatArray):
        """Output, states and gates, over the steps: z keeps, r resets, n is new; h' = z h + (1 - z) n."""
        w, u, b, v, c = self._parts(flat)
        driven = x.T[:, None, :, None] * w[:, None] + b[:, None]
        states, gates = np.zeros((len(driven) + 1, *driven.shape[2:])), np.empty_like(driven)
        keep_and_reset = u[:2].transpose(0, 2, 1)
        for step, drive in enumerate(driven):
            h = states[step]
            z, r = 1 / (1 + np.exp(-(drive[:2] + h @ keep_and_reset)))
            n = np.tanh(drive[2] + (r * h) @ u[2].T)
            states[step + 1] = z * h + (1 - z) * n
            gates[step] = z, r, n
        return (states[1:] @ v + c[0]).T, states, gates

    def loss(self, flat: FloatArray, x: FloatArray, truth: FloatArray, counts: FloatArray):
        """Mean squared error over the rows that count, and its gradient."""
        _, u, _, v, _ = self._parts(flat)
        out, states, gates = self._forward(flat, x)
        error = (out - truth) * counts
        total = counts.sum()
        slope = 2 * error.T / total
        pushed, dh = np.empty_like(gates), np.zeros_like(states[0])
        for step in range(len(gates) - 1, -1, -1):
            h, (z, r, n) = states[step], gates[step]
            dh = dh + slope[step, :, None] * v
            a_n = dh * (1 - z) * (1 - n * n)
            reset = a_n @ u[2]
            pushed[step] = dh * (h - n) * z * (1 - z), reset * h * r * (1 - r), a_n
            dh = dh * z + pushed[step, 0] @ u[0] + pushed[step, 1] @ u[1] + reset * r
        gradient = np.zeros_like(flat)
        dw, du, db, dv, dc = self._parts(gradient)
        before = states[:-1]
        dw += np.einsum("tksi,st->ki", pushed, x)
        du += np.einsum("tksi,ktsj->kij", pushed, np.stack([before, before, gates[:, 1] * before]))
        db += pushed.sum(axis=(0, 2))
        dv += np.einsum("ts,tsi->i", slope, states[1:])
        dc += slope.sum()
        return float(np.sum(error**2) / total), gradient


class Tcn:
    """Causal convolutions of two taps, 1, 2, 4, ... steps apart, each added to what came in; (sequences, steps)."""

    def __init__(self, channels: int, layers: int) -> None:
        self.channels, self.layers = channels, layers

    @property
    def parameter_count(self) -> int:
        """Weights and biases."""
        c = self.channels
        return 2 * c + self.layers * (2 * c * c + c) + c + 1

    def start(self, rng: np.random.Generator) -> FloatArray:
        """Random weights."""
        c = self.channels
        flat = rng.standard_normal(self.parameter_count) / np.sqrt(2 * c)
        flat[: 2 * c] *= np.sqrt(2 * c)
        for layer in self._parts(flat)[2]:
            layer[2 * c * c :] = 0.0
        flat[-1] = 0.0
        return flat

    def _parts(self, flat: FloatArray):
        c, size = self.channels, 2 * self.channels**2 + self.channels
        body = flat[2 * c : 2 * c + self.layers * size].reshape(self.layers, size)
        return flat[:c], flat[c : 2 * c], body, flat[2 * c + self.layers * size : -1], flat[-1:]

    def __call__(self, flat: FloatArray, x: FloatArray) -> FloatArray:
        """Output at every step."""
        return self._forward(flat, x)[0]

    def _forward(self, flat: FloatArray, x: FloatArray):
        c = self.channels
        gain, bias, body, v, offset = self._parts(flat)
        value = np.tanh(x[..., None] * gain + bias)
        values, actives = [value], []
        for number, layer in enumerate(body):
            taps, shift = layer[: 2 * c * c].reshape(2 * c, c), layer[2 * c * c :]
            active = np.maximum(np.concatenate([value, _delayed(value, 2**number)], axis=-1) @ taps + shift, 0.0)
            value = value + active
            values.append(value)
            actives.append(active)
        return value @ v + offset[0], values, actives

    def loss(self, flat: FloatArray, x: FloatArray, truth: FloatArray, counts: FloatArray):
        """Mean squared error over the rows that count, and its gradient."""
        c = self.channels
        _, _, body, v, _ = self._parts(flat)
        out, values, actives = self._forward(flat, x)
        error = (out - truth) * counts
        total = counts.sum()
        slope = 2 * error / total
        gradient = np.zeros_like(flat)
        d_gain, d_bias, d_body, d_v, d_offset = self._parts(gradient)
        d_v += values[-1].reshape(-1, c).T @ slope.ravel()
        d_offset += slope.sum()
        back = slope[..., None] * v
        for number in range(self.layers - 1, -1, -1):
            inner = back * (actives[number] > 0)
            value, late = values[number], _delayed(values[number], 2**number)
            taps = body[number][: 2 * c * c].reshape(2 * c, c)
            stacked = np.concatenate([value, late], axis=-1).reshape(-1, 2 * c)
            d_body[number][: 2 * c * c] += (stacked.T @ inner.reshape(-1, c)).ravel()
            d_body[number][2 * c * c :] += inner.reshape(-1, c).sum(axis=0)
            through = inner @ taps.T
            back = back + through[..., :c] + _advanced(through[..., c:], 2**number)
        first = back * (1 - values[0] ** 2)
        d_gain += (first * x[..., None]).reshape(-1, c).sum(axis=0)
        d_bias += first.reshape(-1, c).sum(axis=0)
        return float(np.sum(error**2) / total), gradient


def _delayed(values: FloatArray, steps: int) -> FloatArray:
    """As they were `steps` ago; before the beginning as at the beginning."""
    head = np.repeat(values[:, :1], min(steps, values.shape[1]), axis=1)
    return np.concatenate([head, values[:, :-steps]], axis=1) if steps < values.shape[1] else head


def _advanced(slopes: FloatArray, steps: int) -> FloatArray:
    """Transpose of `_delayed`."""
    count = slopes.shape[1]
    out = np.zeros_like(slopes)
    if steps < count:
        out[:, :-steps] = slopes[:, steps:]
    out[:, 0] += slopes[:, : min(steps, count)].sum(axis=1)
    return out


def gradient_error(network: Gru | Tcn) -> float:
    """Largest deviation of the gradient from central differences, relative to its norm."""
    rng = np.random.default_rng(0)
    flat = network.start(rng) + 0.1 * rng.standard_normal(network.parameter_count)
    x, truth = rng.standard_normal((2, 2, 12))
    counts = (rng.random((2, 12)) < 0.8).astype(float)
    _, gradient = network.loss(flat, x, truth, counts)
    step, found = 1e-6, np.empty_like(flat)
    for index in range(len(flat)):
        moved = np.zeros_like(flat)
        moved[index] = step
        up, down = (network.loss(flat + sign * moved, x, truth, counts)[0] for sign in (1, -1))
        found[index] = (up - down) / (2 * step)
    return float(np.abs(found - gradient).max() / np.linalg.norm(gradient))


if __name__ == "__main__":
    for network in (Gru(4), Tcn(3, 5)):
        print(f"{type(network).__name__}: gradient off by {gradient_error(network):.1e} of its norm")
