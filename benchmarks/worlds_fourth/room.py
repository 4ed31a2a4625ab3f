"""Temperature of the room since the start, of a largest change of 1: a walk, an air conditioner, an open door."""

from __future__ import annotations

import numpy as np

from worlds_fourth.kernels.followers import wander
from worlds_fourth.operators import lowpass
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, Record

ROOMS = ("walk", "air_conditioner", "door")


def room_of(record: Record, kind: str) -> Array:
    """Temperature over the recording, shape (n,), in units of its largest change.

    Parameters
    ----------
    record : Record
        Each has a room of its own.
    kind : str
        One of `ROOMS`.
    """
    rng = record.stream("temp", "T")
    warm = {"walk": _walk, "air_conditioner": _air_conditioner, "door": _door}[kind](rng, record.time_s)
    warm = warm - warm[0]
    return warm / max(1e-9, np.abs(warm).max())


def _walk(rng: Rng, time_s: Array) -> Array:
    every_s = np.arange(0, time_s[-1] + 5, 1.0)
    tau_s = rng.uniform(40, 90)
    path = wander(rng.normal(size=len(every_s)), tau_s)
    return lowpass(np.interp(time_s, every_s, path), time_s, 15.0)


def _air_conditioner(rng: Rng, time_s: Array) -> Array:
    """On for a part of its period, off for the rest."""
    period_s, part = rng.uniform(70, 180), rng.uniform(0.3, 0.6)
    start_s = rng.uniform(0, period_s)
    on = (((time_s + start_s) % period_s) < part * period_s).astype(float)
    return lowpass(on, time_s, rng.uniform(15, 40), 0.5)


def _door(rng: Rng, time_s: Array) -> Array:
    """Colder within seconds, warm again within a minute or so."""
    at_s, back_s = time_s[-1] * rng.uniform(0.2, 0.6), rng.uniform(25, 70)
    since = np.maximum(time_s - at_s, 0)
    return -np.where(time_s > at_s, np.exp(-since / back_s) * (1 - np.exp(-since / 6)), 0)
