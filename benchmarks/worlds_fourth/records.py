"""A recording before the instruments: motion, drift, and what the measure of strength takes out."""

from __future__ import annotations

import numpy as np

from worlds_fourth.laws import drift_of
from worlds_fourth.motion import make_motion
from worlds_fourth.randoms import stream
from worlds_fourth.signals import GAUGE_LENGTH_MM, Array, Record
from worlds_fourth.specimen import Specimen

STILL = 4e-5  # strain a second; slower is a hold


def make_record(specimen: Specimen, name: str, minutes: float, rate_hz: float) -> Record:
    """Move the carriage for one recording of this specimen."""
    time_s, displacement_mm = make_motion(specimen.seed, name, specimen.end, minutes, rate_hz)
    rng = stream(specimen.seed, "state", name)
    strain = displacement_mm / GAUGE_LENGTH_MM
    rate = np.gradient(strain, time_s)
    share = strain / specimen.end
    drift = drift_of(specimen.drift, specimen.drift_place, specimen.drift_height, rng, time_s, share)
    plane = _plane(share, rate, time_s)
    return Record(name, specimen.seed, time_s, displacement_mm, strain, rate, plane, drift)


def _plane(share: Array, rate: Array, time_s: Array) -> Array:
    """A cubic over strain, the direction of motion and a line over time, made orthonormal."""
    way = np.sign(rate)
    way[np.abs(rate) < STILL] = 0
    columns = [np.ones_like(share), share, share**2, share**3, way, time_s / time_s[-1]]
    return np.linalg.qr(np.column_stack(columns))[0]
