"""The network of contacts: ln of its relative conductance from what drives it, then what lies around it.

A member is a function ``(drive, e, ...) -> ln Gc``. Its drive is the relative force, or the relative strain for the
members in `STRAIN_DRIVEN`. `around` then adds the yarn in series or the floats across the contacts.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from worlds_second.draws import lin, log, pick
from worlds_second.kernels import Array
from worlds_second.laws.registry import law

STRAIN_DRIVEN = frozenset({"sigmoid_strain", "exponential_strain", "tunnelling"})
BUCKLING = 0.05  # of full scale


def _load(drive: Array) -> Array:
    """Load on the contacts: the drive, that a fabric about to buckle loses softly and never turns round."""
    return 0.5 * (drive + np.sqrt(drive**2 + BUCKLING**2))


def _holm(drive: Array, exponent: float, closed: float) -> Array:
    return exponent * np.log(_load(drive) + closed)


@law("contact", exponent=lin(0.12, 0.6), closed=log(0.02, 0.15))
def holm(drive: Array, e: Array, exponent: float, closed: float) -> Array:
    """Conductance is a power of the force on the contacts (Holm 1967), some of which are closed without load."""
    return _holm(drive, exponent, closed)


@law("contact", exponent=lin(0.3, 0.9), closed=log(0.02, 0.15), yarn=log(0.1, 0.8), lengthening=lin(0.0, 0.5))
def holm_series(drive: Array, e: Array, exponent: float, closed: float, yarn: float, lengthening: float) -> Array:
    """Power of force, in series with the resistance of the yarn itself."""
    return _holm(drive, exponent, closed)


@law("contact", exponent=lin(0.3, 0.9), closed=log(0.02, 0.15), floats=log(0.1, 0.8))
def holm_floats(drive: Array, e: Array, exponent: float, closed: float, floats: float) -> Array:
    """Power of force, with floats that bridge the contacts in parallel."""
    return _holm(drive, exponent, closed)


@law("contact", rise=lin(0.3, 1.2), centre=lin(0.2, 0.6), width=lin(0.1, 0.25), sign=pick(-1.0, 1.0))
def sigmoid_strain(drive: Array, e: Array, rise: float, centre: float, width: float, sign: float) -> Array:
    """Contacts that close (or part) around one strain."""
    return sign * rise / (1.0 + np.exp(-(drive - centre) / width))


@law("contact", gauge=log(0.2, 1.5), sign=pick(-1.0, 1.0))
def exponential_strain(drive: Array, e: Array, gauge: float, sign: float) -> Array:
    """The same percentage for each further percent of strain."""
    return sign * gauge * drive


@law("contact", spread=lin(0.2, 1.0), barrier=log(0.2, 1.0), power=lin(1.0, 1.6))
def tunnelling(drive: Array, e: Array, spread: float, barrier: float, power: float) -> Array:
    """Particles that part: the path gets longer and every gap wider (after Zhang 2000)."""
    open_ = np.maximum(drive, 0.0)
    return -np.log1p(spread * open_) - barrier * open_**power


@law("contact", rise=lin(0.4, 2.5), half=log(0.15, 1.0))
def langmuir_force(drive: Array, e: Array, rise: float, half: float) -> Array:
    """The number of contacts rises with force towards all there are."""
    load = _load(drive)
    return np.log1p(rise * load / (load + half))


def around(name: str, ln_contact: Array, e: Array, parameters: Mapping[str, float]) -> Array:
    """ln of the whole relative conductance from that of the contacts."""
    if name == "holm_series":
        yarn = parameters["yarn"] * (1.0 + parameters["lengthening"] * e)
        return -np.log(np.exp(-ln_contact) + yarn)
    if name == "holm_floats":
        return np.logaddexp(ln_contact, np.log(parameters["floats"]))
    return ln_contact
