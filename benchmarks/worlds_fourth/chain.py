"""The chain from the motion to both readings, with the effects at their stages."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from worlds_fourth.effects.effect import Effect
from worlds_fourth.operators import highpass, softplus
from worlds_fourth.signals import GAUGE_LENGTH_MM, Array, Hook, Record, State
from worlds_fourth.specimen import Specimen

Sized = Sequence[tuple[Effect, float]]  # effects with their sizes
LIMP_N = 3e-3  # below, the force goes smoothly to 0: a knit cannot push


def respond(specimen: Specimen, record: Record, effects: Sized) -> tuple[Array, Array]:
    """Force in N and ln R, R in ohm, before noise and converters.

    Parameters
    ----------
    specimen : Specimen
    record : Record
        What does not depend on the effects is kept in it.
    effects : sequence of (Effect, float)
        Hidden effects with their sizes.
    """
    state, moved = _moved(record, effects)
    force = _act(effects, "force", state, _force(specimen, state, moved))
    changed = moved or bool(_hooks(effects, "force"))
    state.force_N = LIMP_N * softplus(force / LIMP_N)
    share = state.strain / specimen.end
    state.share = np.where(share < 0, 0.02 * np.expm1(np.minimum(share, 0) / 0.02), share)
    log_g = _act(effects, "conductance", state, _log_g(specimen, state, effects, moved, changed))
    log_r = specimen.log_r_middle + specimen.conduction.middle - log_g + record.drift
    read_N = _act(effects, "force_reading", state, state.force_N + specimen.instruments.zero_N)
    return read_N, _act(effects, "resistance_reading", state, log_r)


def plain(specimen: Specimen, record: Record) -> tuple[Array, Array]:
    """The same without any effect, computed once for each recording."""
    if "plain" not in record.kept:
        record.kept["plain"] = respond(specimen, record, [])
    return record.kept["plain"]


def _hooks(effects: Sized, stage: str) -> list[tuple[Hook, float]]:
    return [(effect.hooks[stage], size) for effect, size in effects if stage in effect.hooks]


def _act(effects: Sized, stage: str, state: State, signal: Array) -> Array:
    for hook, size in _hooks(effects, stage):
        signal = hook(state, signal, size)
    return signal


def _moved(record: Record, effects: Sized) -> tuple[State, bool]:
    """Motion of the specimen, and whether it is another than that of the carriage."""
    state = State(record, record.displacement_mm, record.strain)
    state.displacement_mm = _act(effects, "displacement", state, record.displacement_mm)
    state.strain = _act(effects, "strain", state, state.displacement_mm / GAUGE_LENGTH_MM)
    return state, bool(_hooks(effects, "displacement") or _hooks(effects, "strain"))


def _force(specimen: Specimen, state: State, moved: bool) -> Array:
    """Elastic force, friction and what relaxes; fills in the state."""
    record = state.record
    if not moved and "force" in record.kept:
        state.elastic_N, state.friction_N, force, state.rate_per_s = record.kept["force"]
        return force
    state.elastic_N = specimen.elasticity.force_N(state.strain)
    state.friction_N = specimen.friction.loop_N(state.strain, state.elastic_N)
    state.rate_per_s = np.gradient(state.strain, record.time_s) if moved else record.rate_per_s
    force = state.elastic_N + state.friction_N
    if specimen.viscosity:
        force = force + specimen.viscosity * highpass(state.elastic_N, record.time_s, specimen.viscosity_s)
    if not moved:
        record.kept["force"] = (state.elastic_N, state.friction_N, force, state.rate_per_s)
    return force


def _log_g(specimen: Specimen, state: State, effects: Sized, moved: bool, changed: bool) -> Array:
    """ln G by the contacts and the length, before the effects on it."""
    record, kept = state.record, state.record.kept
    changed = changed or bool(_hooks(effects, "driver"))
    if not changed and "log_g" in kept:
        return kept["log_g"]
    driver = _act(effects, "driver", state, _driver(specimen, state))
    log_g = specimen.conduction.log_g(driver, state.strain)
    if specimen.contact_loops.on_log_g is not None:
        log_g = log_g + _loops(specimen, state, moved)
    if not changed:
        record.kept["log_g"] = log_g
    return log_g


def _driver(specimen: Specimen, state: State) -> Array:
    """What drives the contacts: strain and force, with what the contacts feel of the friction."""
    loops, w = specimen.contact_loops, specimen.conduction.strain_share
    pressure = (state.force_N + (loops.friction_felt - 1) * state.friction_N) / specimen.top_N
    driver = w * state.share + (1 - w) * pressure
    if specimen.contact_viscosity:
        late = highpass(driver, state.record.time_s, specimen.contact_viscosity_s)
        driver = driver + specimen.contact_viscosity * late
    return driver if loops.on_driver is None else loops.on_driver(driver)


def _loops(specimen: Specimen, state: State, moved: bool) -> Array:
    """Loops of the contacts over strain, which no effect changes that does not move the specimen."""
    kept = state.record.kept
    if not moved and "loops" in kept:
        return kept["loops"]
    assert specimen.contact_loops.on_log_g is not None
    loops = specimen.contact_loops.on_log_g(np.clip(state.share, 0, 1.1))
    if not moved:
        kept["loops"] = loops
    return loops
