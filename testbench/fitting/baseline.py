"""The baseline model for a recording: which laws, and where their search starts."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from testbench.fitting.contact_start import contact_start, driven_contact
from testbench.fitting.parameters import FRAME_PARAMETERS
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.knit.effect import Effect, FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL

FORCE_SHAPES = ("elasticity_shape", "hysteresis_shape")
CONDUCTANCE_SHAPES = ("contact_shape", "contact_loops_shape", "contact_drift_shape", "drift_shape")
SHAPES = FORCE_SHAPES + CONDUCTANCE_SHAPES
ZEROS = ("displacement_zeros", "force_zeros")  # of several recordings in a row, clamped anew for each


def starting_baseline(measurement: Measurement, catalogue: Catalogue | None = None) -> KnitModel:
    """Elasticity, hysteresis, contact (or piezoresistance), drift and the age of each reading, started from the data.

    A recording without force gets no force laws beyond what its conductance needs; one without resistance gets no
    electrical laws. Conductance that falls with stretch gets `piezoresistance` in place of `contact`. Where force and
    conductance are both known, contacts may feel the strain instead of the force.
    """
    effects = (catalogue or load_catalogue()).effects
    seen = measurement.seen
    strain = measurement.signals["strain"][seen]
    laws: list[Effect] = []
    force = measurement.measured.get(FORCE_CHANNEL)
    log_g = measurement.measured.get(CONDUCTANCE_CHANNEL)
    falls = log_g is not None and _slope(strain, log_g[seen]) < 0
    if force is not None or not falls:
        laws += _force_laws(effects, strain, None if force is None else force[seen])
    if force is not None:
        laws.append(effects["force_age"]())
    if log_g is None:
        return KnitModel.of(*laws)
    log_g = log_g[seen]
    last = effects["drift"].model_validate({"per_decade": 0.0}), effects["conductance_age"]()
    if falls:
        signals = {"strain": strain, "conductance_S": np.exp(log_g)}
        return KnitModel.of(*laws, effects["piezoresistance"]().started(signals, {}), *last)
    if force is None:
        contacts: list[Effect] = [contact_start(effects["contact"](), _pressing(laws, measurement)[seen], log_g)]
    else:
        contacts = _driven_contact(measurement, effects)
    return KnitModel.of(*laws, *contacts, *last)


def kinds_of_conduction(model: KnitModel, measurement: Measurement, catalogue: Catalogue) -> list[KnitModel]:
    """The model and, where it makes the conductance from the strain, also the one with contacts under the force.

    Conductance that falls with stretch may be that of contacts: an effect on them may turn a whole recording round.
    """
    of_strain = any(effect.mechanism == "piezoresistance" for effect in model.effects.values())
    if not (of_strain and {FORCE_CHANNEL, CONDUCTANCE_CHANNEL} <= measurement.measured.keys()):
        return [model]
    drive, contact = _driven_contact(measurement, catalogue.effects)
    return [model, model.plus(drive).plus(contact)]


def _driven_contact(measurement: Measurement, effects: dict[str, type[Effect]]) -> list[Effect]:
    """Contacts and what they feel, drawn to the measured strain, force and ln G."""
    seen, measured = measurement.seen, measurement.measured
    strain, force, log_g = measurement.signals["strain"], measured[FORCE_CHANNEL], measured[CONDUCTANCE_CHANNEL]
    return driven_contact(effects["contact_drive"](), effects["contact"](), strain[seen], force[seen], log_g[seen])


def with_zeros(model: KnitModel, measurement: Measurement, catalogue: Catalogue) -> KnitModel:
    """The model with the zeros of each of several recordings free, if the sensor was clamped anew for each."""
    begins_s = measurement.begins_s
    if not (begins_s and measurement.clamp_play_mm):
        return model
    effects, none = catalogue.effects, (0.0,) * len(begins_s)
    model = model.plus(effects["displacement_zeros"].model_validate({"begins_s": begins_s, "strain": none}))
    if FORCE_CHANNEL in measurement.measured:
        model = model.plus(effects["force_zeros"].model_validate({"begins_s": begins_s, "force_N": none}))
    return model


def without_zeros(model: KnitModel) -> KnitModel:
    """The model of the sensor alone, whatever recording it is compared with."""
    return without_laws(model, ZEROS)


def laws_that_may_act(model: KnitModel, measurement: Measurement, catalogue: Catalogue) -> list[Effect]:
    """Base laws that only some recordings need: the model has none at their stage, and the data give them a start."""
    if FORCE_CHANNEL not in measurement.measured:
        return []
    signals = {"strain": measurement.signals["strain"], "force_N": measurement.measured[FORCE_CHANNEL]}
    stages = {effect.stage for effect in model.effects.values()}
    laws = (law for law in catalogue.effects.values() if law.in_base)
    missing = [law() for law in laws if law.stage not in stages and set(law.writes) <= signals.keys()]
    return [law.near(**start) for law in missing for start in law.starting_points(signals, {})]


def _slope(x: FloatArray, y: FloatArray) -> float:
    return float(np.cov(x, y)[0, 1])


def _force_laws(effects: dict[str, type[Effect]], strain: FloatArray, force: FloatArray | None) -> list[Effect]:
    if force is None:
        return [effects["elasticity"](), effects["hysteresis"]()]
    elasticity = effects["elasticity"]().started({"strain": strain, "force_N": force}, {})
    span = float(np.ptp(strain))
    # A glitch of the load cell may lie far beyond what a friction can be.
    hysteresis = effects["hysteresis"]().near(
        friction_N=0.05 * float(np.ptp(force)), threshold=float(np.clip(0.05 * span, 1e-3, 0.3))
    )
    return [elasticity, hysteresis]


def _pressing(laws: list[Effect], measurement: Measurement) -> FloatArray:
    """Force that presses the contacts, where it was not measured: simulated by the laws as they start."""
    return KnitModel.of(*laws).simulate(measurement.signals, measurement.dt_s)["force_N"]


def framed(effect: Effect, model: KnitModel, measurement: Measurement) -> Effect:
    """`effect` with its frame parameters (the range its shape covers) set from the data."""
    fields = set(type(effect).model_fields) & FRAME_PARAMETERS
    if not fields:
        return effect
    frame = {"span": max(float(np.max(measurement.signals["strain_nominal"])) * 1.02, 1e-3)}
    state = model.simulate(measurement.signals, measurement.dt_s)
    if "force_N" in state:
        frame["tension_N"] = max(float(np.max(state["force_N"])), 1e-3)
    force = state.get("contact_force_N")
    if force is not None:
        low, high = float(np.min(force)), float(np.max(force))
        frame |= {"low_N": low, "span_N": max(high - low, 1e-3)}
    return effect.near(**{key: frame[key] for key in fields if key in frame})


def without_shapes(model: KnitModel) -> KnitModel:
    """The model with its base laws unbent."""
    return without_laws(model, SHAPES)


def without_laws(model: KnitModel, names: Iterable[str]) -> KnitModel:
    """The model without those of the laws `names` that it has."""
    for name in names:
        model = model.without(name) if name in model else model
    return model


def with_shapes(
    model: KnitModel, measurement: Measurement, catalogue: Catalogue | None = None, like: KnitModel | None = None
) -> KnitModel:
    """Add shape freedom to every base law that the model has, framed by the range of the data.

    Shapes that the model `like` has start as they are there.
    """
    effects = (catalogue or load_catalogue()).effects
    wanted: tuple[str, ...] = ()
    if FORCE_CHANNEL in measurement.measured:
        wanted += FORCE_SHAPES
    if CONDUCTANCE_CHANNEL in measurement.measured:
        wanted += CONDUCTANCE_SHAPES
    for name in wanted:
        if name not in model:
            shape = like[name] if like is not None and name in like else effects[name]()
            model = model.plus(framed(shape, model, measurement))
    return model
