"""Effects on what presses the contacts: the conductance feels them, the force does not."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_third import kernels
from worlds_third.effects.form import Form, form_of
from worlds_third.signals import Signals

FORMS: list[Form] = []
_form = partial(form_of, FORMS, stage="pressure", main="conductance")
Rng = np.random.Generator


@_form("contact_relaxation", limit=0.7, tau_s=(3.0, 90.0))
def yielding_spots(s: Signals, size: float, rng: Rng, tau_s: float) -> None:
    """Part of the pressure is lost to neighbours within a time."""
    s.pressure = s.pressure - size * kernels.follow(s.pressure, s.step_s, tau_s, tau_s, 0.0)


@_form("contact_relaxation", limit=0.7, order=(0.1, 0.4))
def many_times(s: Signals, size: float, rng: Rng, order: float) -> None:
    """The same over three decades of time."""
    taus = np.geomspace(1.0, 1000.0, 6)
    weights = taus**-order / np.sum(taus**-order)
    lost = sum(w * kernels.follow(s.pressure, s.step_s, t, t, 0.0) for w, t in zip(weights, taus, strict=True))
    s.pressure = s.pressure - size * lost


@_form("contact_relaxation", limit=1.0, press_s=(1.0, 15.0), part=(3.0, 10.0))
def presses_fast_parts_slowly(s: Signals, size: float, rng: Rng, press_s: float, part: float) -> None:
    """Contacts close sooner than adhesion lets them part."""
    late = kernels.follow(s.pressure, s.step_s, press_s, press_s * part, s.pressure[0])
    s.pressure = s.pressure + size * (late - s.pressure)


@_form("contact_saturation", limit=30.0)
def all_spots_used(s: Signals, size: float, rng: Rng) -> None:
    """Langmuir: free spots run out; half are used at pressure 1/size."""
    p = np.maximum(s.pressure, 0.0)
    s.pressure = np.where(s.pressure > 0, p * (1.0 + size) / (1.0 + size * p), s.pressure)


@_form("contact_saturation", limit=0.95, width=(0.02, 0.08))
def plateau(s: Signals, size: float, rng: Rng, width: float) -> None:
    """Rises no further than a level, 1.5 (out of reach) at size 0 and 0 at size 1, rounded."""
    level, width = 1.5 - 1.5 * size, width * min(1.0, 3.0 * size) + 1e-9
    s.pressure = s.pressure - width * np.logaddexp(0.0, (s.pressure - level) / width)
