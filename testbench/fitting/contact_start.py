"""Where the search for the contact law starts: from force, strain and ln G alone, without the rest of the model.

The law's parameters lie in a curved valley along which a fit of the whole model creeps; here a step costs nothing, so
the valley is walked to its end beforehand, from several sides.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from testbench.knit.effect import Effect, FloatArray, bounds_of

SAMPLES = 300
EXPONENTS = (0.5, 1.0)
SHARES = (0.0, 1.0, 0.5)  # of the strain in what the contacts feel
STILL_SEEN = 0.02  # of the resistance or conductance, in series or parallel: less than that hardly shows
PRELOAD = 0.07  # of the range of the force: how much the contacts of a resting knit usually feel
PRELOADS = (0.001, 30.0)  # of that range, at least and at most: beyond, the law does not change any more
SMALLEST_N = 1e-9  # range of a force that does not change
NARROWEST = 0.1  # of a parameter's range, in its logarithm, where the resistance is beyond all that is allowed
CLEARLY_LESS = 0.8  # of the misfit of the usual start: where a less usual one has less, it is taken


def driven_contact(
    drive: Effect, contact: Effect, strain: FloatArray, force: FloatArray, log_g: FloatArray
) -> list[Effect]:
    """`drive` and `contact`, started: with the share of strain in what the contacts feel that explains ln G best.

    Parameters
    ----------
    drive, contact : Effect
        `contact_drive` and `contact`, to be started.
    strain, force, log_g : ndarray, shape (n,)
        As measured.
    """
    low_N, high_N = float(np.min(force)), float(np.max(force))
    frame = {"low_N": low_N, "span_N": high_N - low_N, "span": float(np.max(strain))}
    signals = {"strain": strain, "contact_force_N": force}
    drives = [drive.near(strain_share=share, **frame) for share in SHARES]
    felt = [one.apply(signals, 1.0)["contact_force_N"] for one in drives]
    starts = [_best_start(contact, pressing, log_g) for pressing in felt]
    best = _first_of_the_best([misfit for _, misfit in starts])
    return [drives[best], starts[best][0]]


def contact_start(contact: Effect, pressing: FloatArray, log_g: FloatArray) -> Effect:
    """The contact law fitted to pressing force and ln G on a few samples."""
    return _best_start(contact, pressing, log_g)[0]


def _best_start(contact: Effect, pressing: FloatArray, log_g: FloatArray) -> tuple[Effect, float]:
    stride = max(len(pressing) // SAMPLES, 1)
    guesses = [_guess(contact, pressing, log_g, one) for one in EXPONENTS]
    starts = [_fitted(one, pressing[::stride], log_g[::stride]) for one in guesses]
    return starts[_first_of_the_best([misfit for _, misfit in starts])]


def _first_of_the_best(misfits: Sequence[float]) -> int:
    """The first, the usual one, unless a later one is clearly better."""
    best = 0
    for index, misfit in enumerate(misfits):
        if misfit < CLEARLY_LESS * misfits[best]:
            best = index
    return best


def _guess(contact: Effect, pressing: FloatArray, log_g: FloatArray, exponent: float) -> Effect:
    """Contacts that make most of the resistance in the middle of the force."""
    median_ohm, preload_N = float(np.exp(-np.median(log_g))), PRELOAD * float(np.ptp(pressing))
    middle_N = max(float(np.median(pressing)), 0.0) + preload_N
    return contact.near(
        contact_resistance_ohm=median_ohm * middle_N**exponent,
        parallel_S=0.05 / median_ohm,
        series_ohm=0.1 * median_ohm,
        preload_N=preload_N,
        exponent=exponent,
    )


def _fitted(contact: Effect, pressing: FloatArray, log_g: FloatArray) -> tuple[Effect, float]:
    """The law and its robust misfit."""
    keys = list(type(contact).model_fields)
    bounds = [bounds_of(type(contact).model_fields[key]) for key in keys]
    low, high = (np.log([extra[side] for extra in bounds]) for side in ("low", "high"))
    # Far below the rest of the resistance nothing depends on these any more: no fit finds its way back from there.
    median_ohm = float(np.exp(-np.median(log_g)))
    for key, least in (("series_ohm", STILL_SEEN * median_ohm), ("parallel_S", STILL_SEEN / median_ohm)):
        at_most = high[keys.index(key)] - NARROWEST
        low[keys.index(key)] = np.clip(np.log(least), low[keys.index(key)], at_most)
    load, preloads_N = keys.index("preload_N"), np.multiply(PRELOADS, max(float(np.ptp(pressing)), SMALLEST_N))
    low[load] = np.clip(np.log(preloads_N[0]), low[load], high[load] - NARROWEST)
    high[load] = np.clip(np.log(preloads_N[1]), low[load] + NARROWEST, high[load])
    signals = {"contact_force_N": pressing}

    def at(x: FloatArray) -> Effect:
        return contact.replaced(**dict(zip(keys, (float(v) for v in np.exp(np.clip(x, low, high))), strict=True)))

    def misfit(x: FloatArray) -> FloatArray:
        return np.log(at(x).apply(signals, 1.0)["conductance_S"]) - log_g

    start = np.clip(np.log([getattr(contact, key) for key in keys]), low, high)
    found = least_squares(misfit, start, bounds=(low, high), loss="soft_l1", f_scale=0.05, max_nfev=60)
    return at(found.x), float(found.cost)
