"""Kinds of effect on the fabric that no catalogue has: a diagnosis should say that something is there, no name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.kernels.followers import crystals, curl
from worlds_fourth.kernels.friction import stick_slip, switched
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_snap = partial(form_of, FORMS, "loop_snap")
_broken = partial(form_of, FORMS, "broken_course")
_stick = partial(form_of, FORMS, "yarn_stick_slip")
_crystal = partial(form_of, FORMS, "strain_crystallisation")
_curl = partial(form_of, FORMS, "edge_curl")


def _snapping(rng: Rng, specimen: Specimen, count: int) -> Effect:
    up = np.sort(rng.uniform(0.3, 0.9, count))
    down, shares = up - rng.uniform(0.08, 0.25, count), rng.dirichlet(np.ones(count) * 3)
    of_g = rng.uniform(0.3, 1.0) * rng.choice([-1, 1])

    def snapped(s: State) -> Array:
        x, total = s.strain / specimen.end, np.zeros(len(s.strain))
        for above, below, share in zip(up, down, shares, strict=True):
            total += share * switched(x, above, below, 0.0)
        return total

    hooks = {
        "force": lambda s, force, size: force * (1 - size * snapped(s)),
        "conductance": lambda s, log_g, size: log_g + of_g * size * snapped(s),
    }
    return Effect(f"{count} groups snap at x = {np.round(up, 2)}, back at {np.round(down, 2)}", 0.3, hooks)


@_snap()
def groups(rng: Rng, specimen: Specimen) -> Effect:
    """Groups of loops snap through at one strain and back at another: force and conductance jump."""
    return _snapping(rng, specimen, int(rng.integers(2, 6)))


@_snap()
def one_group(rng: Rng, specimen: Specimen) -> Effect:
    """One group alone."""
    return _snapping(rng, specimen, 1)


def _breaking(rng: Rng, specimen: Specimen, count: int) -> Effect:
    first, of_g = rng.uniform(0.3, 0.7), rng.uniform(0.5, 2.0)

    def broken(x: Array) -> Array:
        total = np.zeros(len(x))
        for k in range(count):
            start = int(len(x) * min(0.9, first + 0.12 * k))
            strong = np.where(x[start:] > 0.6)[0]
            if len(strong):
                total[start + strong[0] :] += 1 / count
        return total

    hooks = {
        "force": lambda s, force, size: force * (1 - size * broken(s.strain / specimen.end)),
        "conductance": lambda s, log_g, size: log_g - of_g * size * broken(s.share),
    }
    return Effect(f"{count} yarns break after {first:.2f} of the time: F (1 - a), ln G - {of_g:.2f} a", 0.4, hooks)


@_broken()
def one_yarn(rng: Rng, specimen: Specimen) -> Effect:
    """A yarn breaks for good, in a stretch."""
    return _breaking(rng, specimen, 1)


@_broken()
def three_yarns(rng: Rng, specimen: Specimen) -> Effect:
    """Three, one after the other."""
    return _breaking(rng, specimen, 3)


def _sticking(rng: Rng, specimen: Specimen, left: float) -> Effect:
    reach = specimen.end * rng.uniform(0.02, 0.06)

    def act(s: State, force: Array, size: float) -> Array:
        jumps = s.record.stream("stsl").uniform(0.4, 1.6, 20_000)
        return force + size * np.maximum(s.elastic_N, 0) * stick_slip(s.strain, jumps, reach, left)

    return Effect(f"saw teeth of a F, every {reach:.4f} of strain or so, both ways", 0.3, {"force": act})


@_stick()
def nearly_released(rng: Rng, specimen: Specimen) -> Effect:
    """Yarns stick and slip, and let go of nearly all."""
    return _sticking(rng, specimen, 0.1)


@_stick()
def beyond(rng: Rng, specimen: Specimen) -> Effect:
    """They spring a little beyond."""
    return _sticking(rng, specimen, -0.2)


def _crystallising(rng: Rng, specimen: Specimen, with_g: bool) -> Effect:
    above, below = rng.uniform(0.5, 0.7), rng.uniform(0.25, 0.45)
    grow_s, melt_s = rng.uniform(0.8, 4), rng.uniform(0.3, 1.5)
    of_g = rng.uniform(-1, 1) if with_g else 0.0

    def grown(s: State) -> Array:
        return crystals(s.strain / specimen.end, np.gradient(s.record.time_s), above, below, grow_s, melt_s)

    hooks = {
        "force": lambda s, force, size: force * (1 - size * grown(s)),
        "conductance": lambda s, log_g, size: log_g + of_g * size * grown(s),
    }
    text = f"crystallites above x = {above:.2f} ({grow_s:.1f} s), molten below {below:.2f} ({melt_s:.1f} s)"
    return Effect(f"{text}: F (1 - a c), ln G {of_g:+.2f} a c", 0.3, hooks)


@_crystal()
def of_the_force(rng: Rng, specimen: Specimen) -> Effect:
    """Crystallites grow in the stretched yarn and take strain out of it."""
    return _crystallising(rng, specimen, with_g=False)


@_crystal()
def of_both(rng: Rng, specimen: Specimen) -> Effect:
    """They change the conductance too."""
    return _crystallising(rng, specimen, with_g=True)


def _rolled(rng: Rng, specimen: Specimen) -> Callable[[State], Array]:
    below, roll_s, reach = rng.uniform(0.15, 0.3), rng.uniform(1.5, 6), rng.uniform(0.05, 0.15)
    return lambda s: curl(s.strain / specimen.end, np.gradient(s.record.time_s), below, roll_s, reach)


@_curl()
def short_circuit(rng: Rng, specimen: Specimen) -> Effect:
    """The edges roll up near the start, within seconds, and touch: more conductance until they are pulled flat."""
    rolled = _rolled(rng, specimen)
    text = "edges roll up near the start and are pulled flat: ln G + a"
    return Effect(text, 0.4, {"conductance": lambda s, log_g, size: log_g + size * rolled(s)})


@_curl()
def stiff_edge(rng: Rng, specimen: Specimen) -> Effect:
    """The rolled edges conduct less and pull more."""
    rolled, top_N = _rolled(rng, specimen), specimen.top_N

    def pull(s: State, force: Array, size: float) -> Array:
        return force + 0.3 * size * top_N * rolled(s) * np.clip(s.strain / specimen.end, 0, 1)

    hooks = {"conductance": lambda s, log_g, size: log_g - size * rolled(s), "force": pull}
    return Effect("edges roll up near the start and are pulled flat: ln G - a, F + 0.3 a x of the top", 0.4, hooks)
