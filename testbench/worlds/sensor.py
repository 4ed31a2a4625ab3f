"""A sensor with an effect hidden in it that goes through any motion: for experiments that are chosen as they go."""

from __future__ import annotations

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.recordings.recording import Recording
from testbench.worlds import strength as strengths
from testbench.worlds.base import draw_world
from testbench.worlds.case import PARTS, Bench, ambient_K, choose, names_of, rng_of
from testbench.worlds.chain import Scene, run
from testbench.worlds.motions import GAUGE_LENGTH_MM, sample_times

HORIZON_S = 4 * 3600.0  # the room is drawn for so long


class HiddenSensor:
    """One specimen and its tester.

    Parameters
    ----------
    effect, strength, world, seed, form
        As in `testbench.worlds.make_case`, whose sensor it is; the strength is that of random motion of `minutes`.
    noise : str
        One of `testbench.worlds.case.NOISES`.
    """

    def __init__(
        self,
        effect: str,
        strength: float,
        world: str,
        seed: int,
        minutes: float = 5.0,
        rate_hz: float = 40.0,
        noise: str = "white",
        form: str | None = None,
    ) -> None:
        base = draw_world(world, rng_of(seed, "base", world))
        self.bench = Bench(base, seed, minutes, rate_hz, noise, "perlin")
        self.hidden = [self.bench.scale(*choose(name, form, seed, base), strength) for name in names_of(effect, seed)]
        self.names = tuple(one.form.effect for one in self.hidden)
        left = self.bench.left_over(PARTS[0], self.hidden) if self.hidden else np.zeros(1)
        self.reached = strengths.rms(left)  # in noise floors; what is out of every form's reach ends lower
        self.seed, self.rate_hz = seed, rate_hz
        self.room_s = np.arange(0.0, HORIZON_S)
        self.room_K = ambient_K(self.room_s, rng_of(seed, PARTS[0], "ambient"))

    def recording(
        self,
        time_s: FloatArray,
        strain: FloatArray,
        past: FloatArray | None = None,
        past_dt_s: float = 0.02,
        run_number: int = 1,
    ) -> Recording:
        """What the instruments write of a motion.

        Parameters
        ----------
        time_s, strain : ndarray, shape (n,)
            The motion.
        past : ndarray, shape (m,), optional
            Strain of the same specimen before, in steps of `past_dt_s`.
        run_number : int
            Another run has other noise and other sampling times.
        """
        rng = rng_of(self.seed, "run", str(run_number))
        t = sample_times(float(time_s[-1]) / 60, self.rate_hz, rng)
        before = np.zeros(0) if past is None else past
        earlier_s = np.arange(len(before)) * past_dt_s
        start_s = len(before) * past_dt_s
        when = np.concatenate([earlier_s, t + start_s])
        whole = np.concatenate([before, np.interp(t, time_s, strain)])
        room = np.interp(when, self.room_s, self.room_K)
        scene = Scene(when, whole, room, self.bench.top_N, self.bench.usual, (self.seed, 7))
        force, ln_g = run(self.bench.base, scene, self.hidden)
        own = slice(len(before), None)
        read = self.bench.read(whole[own], room[own], force[own], ln_g[own], self.hidden, rng, rng)
        return Recording(t, read, GAUGE_LENGTH_MM, "hidden sensor")
