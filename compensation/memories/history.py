"""Two memories that no smoothing of a signal replaces: how much it moved lately, and where it turned round.

*Motion*: a knit's conductance answers to motion as such, in either direction, and recovers at rest. The smoothed
speed ``|ds/dt|`` of the lightly smoothed signal ``s`` says how much motion there was in the last seconds to half a
minute; up and down cancel in every linear filter of ``s`` itself.

*Play*: what friction does. ``y(t) = max(s - r, min(s + r, y(t - 1)))`` follows s only after a turn of more than 2 r;
a few of them with different r hold the turning points that hysteresis depends on (the play, or backlash, operator of
Prandtl and Ishlinskii).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcode.support.arrays import FloatArray

# Light smoothing before the speed is taken: longer than a sample and its noise, shorter than any motion.
SETTLE_S = 0.4
# As short as a sample at 20 Hz: what contacts answer to motion is over within a few tenths of a second.
QUICK_SETTLE_S = 0.05


@dataclass(frozen=True)
class History:
    """Which of these memories a compensator has; none by default."""

    motion_taus_s: tuple[float, ...] = ()  # time constants over which the speed is smoothed
    play_radii: tuple[float, ...] = ()  # half-widths r, in standard deviations of the training's conductance
    settle_s: float = SETTLE_S  # time constant of the light smoothing

    @property
    def count(self) -> int:
        return len(self.motion_taus_s) + len(self.play_radii)

    def features(self, x: FloatArray, dt_s: FloatArray, held: FloatArray) -> FloatArray:
        """Motions, then plays, at each sample.

        Parameters
        ----------
        x : ndarray, shape (n,)
            Standardised conductance.
        dt_s : ndarray, shape (n - 1,)
            Time from each sample to the next.
        held : ndarray, shape (count,)
            What the memories hold at the first sample.

        Returns
        -------
        ndarray, shape (n, count)
        """
        from compensation.memories.compiled_filters import remember

        return remember(x, dt_s, self.settle_s, np.asarray(self.motion_taus_s), np.asarray(self.play_radii), held)


NO_HISTORY = History()


class RunningHistory:
    """The same, sample by sample."""

    def __init__(self, history: History) -> None:
        self._history = history
        self._taus_s, self._radii = np.asarray(history.motion_taus_s), np.asarray(history.play_radii)
        self._settled: float | None = None
        self._motion, self._play = np.zeros(len(self._taus_s)), np.zeros(len(self._radii))

    def update(self, x: float, dt_s: float, held: FloatArray) -> FloatArray:
        """Feed one sample; `dt_s` is ignored for the first, `held` for all others (see `History.features`)."""
        if self._settled is None:
            self._settled = x
            self._motion, self._play = held[: len(self._taus_s)].copy(), held[len(self._taus_s) :].copy()
        elif dt_s > 0:
            step = -np.expm1(-dt_s / self._history.settle_s) * (x - self._settled)
            self._settled += step
            self._motion = self._motion - np.expm1(-dt_s / self._taus_s) * (abs(step) / dt_s - self._motion)
        self._play = np.clip(self._play, self._settled - self._radii, self._settled + self._radii)
        return np.concatenate([self._motion, self._play])
