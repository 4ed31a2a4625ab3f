"""Where the parameters of a law may lie, and where its search starts: what this recording can show."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

import numpy as np
from scipy.signal import periodogram

from testbench.knit.effect import FloatArray
from testbench.knit.filters import rate
from testbench.proposing.laws.law_parts import Slot

LEVELS = (0.1, 0.3, 0.5, 0.7, 0.9, 0.98)  # quantiles; the last: where a few large values are cut off
PEAKS = 0.9  # quantile beyond which the peaks lie: a level is tried half way up to the highest, however few they are
QUICK = (0.3, 0.5, 0.7, 0.85, 0.95, 0.98)  # quantiles of a rate that is exceeded beyond them
SIZES = (0.03, 0.1, 0.3, 1.0, 3.0)  # of the usual size
EDGES = tuple(np.linspace(0.04, 0.96, 16))  # quantiles at which a switch is tried: a sharp thing is found only nearby
NARROW = 0.02  # of the usual size, between the two levels of a switch that share a quantile
CYCLES = np.arange(1.5, 40.0, 0.75)  # over the range: what comes again is found only where its count is nearly right
STRAINS = (0.1, 0.25, 0.4, 0.55, 0.7, 0.85)  # of the span
WIDTHS = np.geomspace(0.03, 0.3, 7)  # of the span, within which a strain is one and the same
PATHS = (0.3, 1.0, 4.0, 16.0)  # spans
TIMES, FEWER_TIMES = 8, 4
NEVER = 10.0  # durations: what flows may hardly come back
HERTZ = (0.15, 3.0)
DAMPINGS = (0.03, 0.15, 0.5)
NUMBERS = (0.5, 1.5, 2.0, 3.0)
DECADES = (1.5, 3.0)
SHORTEST_S = 1e-3  # a state may form in much less than a sample, a whole span beyond its edge
DELAYS_S = (0.1, 0.3, 1.0)
LATE_S, MOST_SKEW = 0.3, 0.05  # clocks are tried in steps of so much at the end of the recording, up to this share
BOUNDS = {  # of kinds that have the same everywhere: least, largest, whether their scale is logarithmic
    "delay": (0.0, 10.0, False),
    "skew": (-2 * MOST_SKEW, 2 * MOST_SKEW, False),
    "frequency": (0.01, 50.0, True),
    "angle": (-20.0, 20.0, False),
}
SHARES = (0.85, 0.95)  # of a last top
SWINGS = (0.02, 0.05)  # of the span, by which the strain has turned
TEETH = ("stick", "dead band")  # that come again with each length of travel
LINES = 4  # strongest frequencies of a residual that are tried
LEAST_LEVEL = 1e-3  # a threshold near zero may still be moved


class Grid:
    """Start values of every kind of parameter, and its bounds.

    Parameters
    ----------
    span : float
        Largest strain of the recording.
    dt_s, duration_s : float
    residual : sequence of ndarray
        What is left of each channel on the whole grid: for its strongest frequencies.
    """

    def __init__(self, span: float, dt_s: float, duration_s: float, residual: Sequence[FloatArray]) -> None:
        self.span, self.dt_s, self.duration_s = span, dt_s, duration_s
        self.periods_s = _strongest_periods(residual, dt_s)

    def points(self, slots: Sequence[Slot], x: FloatArray | None, name: str = "") -> Iterator[dict[str, float]]:
        """Start points of the parameters of one piece whose input is `x`."""
        if name == "wave" and x is not None:
            yield from self._waves(x)
            return
        if name == "switch" and x is not None:
            levels = np.unique(np.quantile(x, EDGES))
            for off, on in itertools.combinations_with_replacement(levels, 2):
                yield {"on": float(on), "gap": float(max(on - off, NARROW * usual_size(x)))}
            return
        if name in TEETH and x is not None:
            for cycles in CYCLES:
                yield {slots[0].key: float(max(np.ptp(x), 1e-9) / cycles)}
            return
        if name == "ring":
            for damping in DAMPINGS:
                yield from ({"ring_hz": hz, "damping": damping} for hz in self._hertz(damping))
            return
        few = len(slots) > 1
        axes = [self._axis(slot, x, few) for slot in slots]
        for values in itertools.product(*axes):
            yield {slot.key: float(v) for slot, v in zip(slots, values, strict=True)}

    def _axis(self, slot: Slot, x: FloatArray | None, few: bool) -> Sequence[float]:
        if slot.kind == "time":
            never = [NEVER * self.duration_s] if slot.key == "back_s" else []
            return [*self.times_s(FEWER_TIMES if few else TIMES), *never]
        if slot.kind == "delay":
            return DELAYS_S
        if slot.kind == "skew":
            steps = np.arange(1, int(MOST_SKEW * self.duration_s / LATE_S) + 1)
            return list(LATE_S / self.duration_s * np.concatenate([-steps[::-1], steps]))
        if slot.kind == "number":
            return {"decades": DECADES, "share": SHARES}.get(slot.key, NUMBERS)
        if slot.kind == "swing" or x is None:  # of the strain
            strains = STRAINS[1::2] if few else STRAINS
            shares = {"strain": strains, "path": PATHS, "swing": SWINGS, "size": WIDTHS}[slot.kind]
            return [share * self.span for share in shares]
        if slot.kind == "rate":
            return list(np.unique(np.quantile(np.abs(rate(x, self.dt_s)), QUICK)) + 1e-12)
        if slot.kind == "level":
            half_way = 0.5 * (np.quantile(x, PEAKS) + np.max(x))
            return list(np.unique([*np.quantile(x, LEVELS), half_way]))
        return [share * usual_size(x) for share in (SIZES[1:4] if few else SIZES)]

    def times_s(self, count: int = TIMES) -> Sequence[float]:
        """Time constants that this recording can show: from a few samples to half its length."""
        return list(np.geomspace(max(3 * self.dt_s, 0.25), 0.5 * self.duration_s, count))

    def _hertz(self, damping: float) -> Iterator[float]:
        """Frequencies half as far apart as a resonance is wide."""
        hz, most = HERTZ[0], min(HERTZ[1], 0.3 / self.dt_s)
        while hz < most:
            yield hz
            hz *= 1 + damping

    def _waves(self, x: FloatArray) -> Iterator[dict[str, float]]:
        straight = abs(len(x) * float(np.mean(np.diff(x))) / max(float(np.ptp(x)), 1e-12)) > 0.99
        if straight and float(np.ptp(x)) > 0.9 * self.duration_s:  # the time itself
            periods = self.periods_s
        else:
            periods = list(max(float(np.ptp(x)), 1e-9) / CYCLES)
        for period in periods:
            for phase in (0.0, np.pi / 2):
                yield {"period": float(period), "phase": phase}

    def bounds(self, slot: Slot, value: float) -> tuple[float, float, bool]:
        """Least and largest value around one that was found, and whether its scale is logarithmic."""
        if slot.kind == "time":
            return min(SHORTEST_S, value), max(1e5, value), True
        if slot.kind in BOUNDS:
            return BOUNDS[slot.kind]
        if slot.kind == "number":
            return slot.low, slot.high, True
        if slot.kind == "level":
            reach = rounded(10 * max(abs(value), LEAST_LEVEL))
            return -reach, reach, False
        if slot.kind == "strain":
            return 0.0, rounded(10 * max(value, 1e-6)), False
        return rounded(value / 100), rounded(value * 100), True


def usual_size(x: FloatArray) -> float:
    """What a signal usually measures: its spread, or its mean where that is larger."""
    return max(float(np.std(x)), 0.5 * abs(float(np.mean(x))), 1e-9)


def rounded(value: float) -> float:
    """To two digits: no more are known of it."""
    return float(f"{value:.1e}")


def _strongest_periods(residual: Sequence[FloatArray], dt_s: float) -> list[float]:
    """Periods of the strongest lines of what is left, those of each channel."""
    found: list[float] = []
    for values in residual:
        hz, power = periodogram(values - values.mean(), 1 / dt_s, window="hann", nfft=4 * len(values))
        power[hz < 3 / (len(values) * dt_s)] = 0.0
        for _ in range(LINES):
            top = int(np.argmax(power))
            if power[top] <= 0:
                break
            found.append(1 / float(hz[top]))
            power[max(top - 12, 0) : top + 13] = 0.0
    return found
