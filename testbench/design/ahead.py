"""Measurements that were not made yet: a motion, and what the specimen went through before it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gcode.trajectories.trajectory import Trajectory
from testbench.knit.effect import FloatArray
from testbench.knit.model import inputs
from testbench.measurements.measurement import Measurement
from testbench.measurements.preparing import BURN_IN_S
from testbench.recordings.channels import DISPLACEMENT
from testbench.recordings.recording import Recording

ROOM_C, SWING_K, SWING_S = 23.0, 1.0, 1500.0  # a room with a thermostat, where the temperature is measured


def planned(
    trajectory: Trajectory, gauge_length_mm: float, channels: Sequence[str], temperature: bool = False
) -> Measurement:
    """The motion of a fresh specimen of which nothing was read yet, at the rate of the plan."""
    time_s = np.arange(round(SWING_S * trajectory.rate_hz)) / trajectory.rate_hz
    still = np.zeros(len(time_s))
    room = ROOM_C + SWING_K * np.sin(2 * np.pi * time_s / SWING_S) if temperature else None
    recording = Recording(time_s, {DISPLACEMENT: still}, gauge_length_mm, "planned experiment")
    unread = dict.fromkeys(channels, still)
    bench = Measurement(inputs(time_s, still, room), 1 / trajectory.rate_hz, unread, still > 0, recording, still)
    return following(bench, trajectory, gauge_length_mm, None)


def following(
    history: Measurement, trajectory: Trajectory, gauge_length_mm: float, rest_s: float | None
) -> Measurement:
    """The motion, after all that the specimen went through and a rest; only what is new counts.

    Parameters
    ----------
    rest_s : float or None
        In which the strain goes from where it was to where the motion begins; None: a fresh specimen.

    Returns
    -------
    Measurement
        The motion is the last of its recordings.
    """
    dt_s = history.dt_s
    time_s = np.arange(0, trajectory.duration_s + dt_s / 2, dt_s)
    new = np.interp(time_s, trajectory.time_s, trajectory.position_mm) / gauge_length_mm
    past = np.zeros(0)
    begins_s: tuple[float, ...] = ()
    averaged: tuple[float, ...] = (1.0,)
    if rest_s is not None:
        seen = history.signals["strain"]
        rest = np.linspace(seen[-1], new[0], max(round(rest_s / dt_s), 1) + 2)[1:-1]
        past = np.concatenate([seen, rest])
        begins_s, averaged = (*history.begins_s, len(past) * dt_s), (*history.averaged, 1.0)
    strain = np.concatenate([past, new])
    signals = inputs(np.arange(len(strain)) * dt_s, strain, _room(history, len(strain), len(past)))
    unread = {channel: np.zeros(len(strain)) for channel in history.measured}
    counts = np.concatenate([np.zeros(len(past), bool), time_s >= BURN_IN_S])
    return replace(
        history,
        signals=signals,
        measured=unread,
        counts=counts,
        strain_noise=np.zeros(len(strain)),
        averaged=averaged,
        begins_s=begins_s,
    )


def _room(history: Measurement, count: int, past: int) -> FloatArray | None:
    """A room that goes on as it was: the temperature read so far, again from its start."""
    if "temperature_C" not in history.signals:
        return None
    seen = history.signals["temperature_C"]
    return np.resize(np.concatenate([seen, seen[::-1]]), count) if past else np.resize(seen, count)
