"""What presses the contacts is not the force alone: relaxing and saturating contacts."""

from __future__ import annotations

import numpy as np

from worlds_second.chain import Signals
from worlds_second.draws import lin, log
from worlds_second.effects.registry import form
from worlds_second.kernels import Array, lag


@form("contact_relaxation", "pressure", 0.9, time_s=log(3.0, 200.0))
def contacts_give_way(s: Signals, m: float, time_s: float) -> Array:
    """A share of the contacts' load relaxes with one time."""
    return s.drive - m * lag(s.drive, s.dt, time_s, start=0.0)


@form("contact_relaxation", "pressure", 0.9, first_s=log(1.0, 6.0), decades=lin(1.5, 2.8))
def contacts_of_many_times(s: Signals, m: float, first_s: float, decades: float) -> Array:
    """A share of the load relaxes over decades of time."""
    arms = [lag(s.drive, s.dt, first_s * 10.0 ** (decades * k), start=0.0) for k in np.linspace(0.0, 1.0, 6)]
    return s.drive - m * np.mean(arms, axis=0)


@form("contact_relaxation", "contact", 0.9, time_s=log(3.0, 150.0), power=lin(1.2, 2.5))
def spots_shrink(s: Signals, m: float, time_s: float, power: float) -> Array:
    """Contact spots shrink in a hold, the large ones most."""
    load = np.maximum(s.drive, 0.0) ** power
    return s.ln_contact - m * lag(load, s.dt, time_s, start=0.0)


@form("contact_saturation", "pressure", 0.95, sharp=lin(4.0, 10.0))
def plateau(s: Signals, m: float, sharp: float) -> Array:
    """The load on the contacts comes to a plateau."""
    load = np.maximum(s.drive, 0.0)
    level = 1.0 - m
    return load / (1.0 + (load / level) ** sharp) ** (1.0 / sharp)


@form("contact_saturation", "pressure", 0.99, level=lin(0.35, 0.65), width=lin(0.01, 0.05))
def spots_full(s: Signals, m: float, level: float, width: float) -> Array:
    """Above a level a share of the contacts takes no more load."""
    return s.drive - m * width * np.logaddexp(0.0, (s.drive - level) / width)


@form("contact_saturation", "pressure", 0.97)
def hard_stop(s: Signals, m: float) -> Array:
    """Contacts bottom out at one load."""
    return np.minimum(s.drive, 1.0 - m)
