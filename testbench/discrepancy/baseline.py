"""The baseline model for a recording: which laws, and where their search starts."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.optimize import least_squares

from testbench.discrepancy.measurement import CONDUCTANCE_CHANNEL, FORCE_CHANNEL, Measurement
from testbench.discrepancy.parameters import FRAME_PARAMETERS
from testbench.knit.catalogue import BASELINE, Catalogue, load_catalogue
from testbench.knit.effect import Effect, FloatArray, bounds_of
from testbench.knit.model import KnitModel

# What a baseline may consist of, as the recording has it.
LAWS = frozenset({*BASELINE, "piezoresistance", "contact_drive", "contact_hysteresis"})
# Bouc-Wen friction is a freedom of the loops, as free slip elements are: neither can imitate all of the other.
LOOP_SHAPES = ("hysteresis_shape", "hysteresis_bouc_wen")
FORCE_SHAPES = ("elasticity_shape", *LOOP_SHAPES)
CONDUCTANCE_SHAPES = ("contact_shape", "drift_shape")
BOUC_WEN_SHARE = 0.3  # of the slip elements' friction, where its search starts
SHAPES = FORCE_SHAPES + CONDUCTANCE_SHAPES


def starting_baseline(measurement: Measurement, catalogue: Catalogue | None = None) -> KnitModel:
    """Elasticity, hysteresis, contact (or piezoresistance) and drift, started from the data.

    A recording without force gets no force laws beyond what its conductance needs; one without resistance gets no
    electrical laws. Conductance that falls with stretch gets `piezoresistance` in place of `contact`. Where force and
    conductance are both known, contacts may feel the strain instead of the force.
    """
    effects = (catalogue or load_catalogue()).effects
    # With the burn-in: in a ramp and hold nearly all of the motion lies there.
    seen = slice(0, int(np.flatnonzero(measurement.counts)[-1]) + 1)
    strain = measurement.signals["strain"][seen]
    laws: list[Effect] = []
    force = measurement.measured.get(FORCE_CHANNEL)
    log_g = measurement.measured.get(CONDUCTANCE_CHANNEL)
    falls = log_g is not None and _slope(strain, log_g[seen]) < 0
    if force is not None or not falls:
        laws += _force_laws(effects, strain, None if force is None else force[seen])
    if log_g is None:
        return KnitModel.of(*laws)
    pressing = _pressing(laws, measurement)[seen]
    if force is not None and not falls:
        drive = _drive(effects["contact_drive"](), strain, force[seen], log_g[seen])
        pressing = drive.apply({"strain": strain, "contact_force_N": pressing}, measurement.dt_s)["contact_force_N"]
        laws.append(drive)
    return KnitModel.of(*laws, *_electrical_laws(effects, falls, strain, log_g[seen], pressing))


def _drive(drive: Effect, strain: FloatArray, force: FloatArray, log_g: FloatArray) -> Effect:
    """What the contacts feel, to start with: the more of strain, the narrower ln G lies over it."""
    by_force, by_strain = (_width_over(x, log_g) for x in (force, strain))
    low_N, high_N = float(np.min(force)), float(np.max(force))
    return drive.near(
        strain_share=by_force / max(by_force + by_strain, 1e-12),
        low_N=low_N,
        span_N=high_N - low_N,
        span=float(np.max(strain)),
    )


def _width_over(x: FloatArray, y: FloatArray, bins: int = 64) -> float:
    """Mean variance of `y` within bins of equal counts over `x`."""
    parts = np.array_split(y[np.argsort(x)], bins)
    return float(np.mean([np.var(part) for part in parts]))


def _slope(x: FloatArray, y: FloatArray) -> float:
    return float(np.cov(x, y)[0, 1])


def _force_laws(effects: dict[str, type[Effect]], strain: FloatArray, force: FloatArray | None) -> list[Effect]:
    if force is None:
        return [effects["elasticity"](), effects["hysteresis"]()]
    stiffness, curvature, offset = _j_curve(strain, force)
    elasticity = effects["elasticity"].model_validate(
        {"stiffness_N": stiffness, "curvature": curvature, "offset_N": offset}
    )
    span = float(np.ptp(strain))
    hysteresis = effects["hysteresis"].model_validate(
        {"friction_N": 0.05 * float(np.ptp(force)), "threshold": float(np.clip(0.05 * span, 1e-3, 0.3))}
    )
    return [elasticity, hysteresis]


def _pressing(laws: list[Effect], measurement: Measurement) -> FloatArray:
    """Force that presses the contacts: as measured, or of the laws as they start."""
    if FORCE_CHANNEL in measurement.measured:
        return measurement.measured[FORCE_CHANNEL]
    state = KnitModel.of(*laws).simulate(measurement.signals, measurement.dt_s)
    return state.get("force_N", measurement.signals["strain"])


def _j_curve(strain: FloatArray, force: FloatArray) -> tuple[float, float, float]:
    """Best stiffness, curvature and offset over a grid of curvatures; each is a linear problem."""
    best = (np.inf, 1.0, 0.0, 0.0)
    for curvature in (-4.0, -2.0, -0.5, 0.5, 1.5, 3.0, 5.0, 8.0):
        shape = np.expm1(curvature * strain) / curvature
        slope, offset = np.polyfit(shape, force, 1)
        error = float(np.sum((force - offset - slope * shape) ** 2))
        if error < best[0]:
            best = (error, slope, curvature, offset)
    return float(np.clip(best[1], 1e-3, 1e4)), best[2], float(np.clip(best[3], -100, 100))


def _electrical_laws(
    effects: dict[str, type[Effect]],
    falls: bool,
    strain: FloatArray,
    log_g: FloatArray,
    pressing: FloatArray,
) -> list[Effect]:
    drift = effects["drift"].model_validate({"per_decade": 0.0})
    if falls:
        return [
            effects["piezoresistance"]().initial_guess({"strain": strain, "conductance_S": np.exp(log_g)}, 1.0),
            drift,
        ]
    median_ohm = float(np.exp(-np.median(log_g)))
    contact = effects["contact"].model_validate(
        {
            "contact_resistance_ohm": median_ohm,
            "parallel_S": 0.05 / median_ohm,
            "series_ohm": 0.1 * median_ohm,
            "preload_N": 0.2,
        }
    )
    return [contact_start(contact, pressing, log_g), drift]


def contact_start(contact: Effect, force: FloatArray, log_g: FloatArray, samples: int = 300) -> Effect:
    """The contact law fitted to measured force and ln G alone, on a few samples.

    Its four parameters lie in a curved valley along which a fit of the whole model creeps; without the rest of the
    model a step costs nothing, so it is walked to the end beforehand.
    """
    keys = list(type(contact).model_fields)
    bounds = [bounds_of(type(contact).model_fields[key]) for key in keys]
    low, high = (np.log([extra[side] for extra in bounds]) for side in ("low", "high"))
    stride = max(len(force) // samples, 1)
    signals = {"contact_force_N": force[::stride]}
    wanted = log_g[::stride]

    def misfit(x: FloatArray) -> FloatArray:
        at = contact.replaced(**dict(zip(keys, np.exp(np.clip(x, low, high)), strict=True)))
        return np.log(at.apply(signals, 1.0)["conductance_S"]) - wanted

    start = np.log([getattr(contact, key) for key in keys])
    found = least_squares(misfit, start, bounds=(low, high), loss="soft_l1", f_scale=0.05, max_nfev=60)
    return contact.replaced(**{key: float(v) for key, v in zip(keys, np.exp(found.x), strict=True)})


def framed(effect: Effect, model: KnitModel, measurement: Measurement) -> Effect:
    """`effect` with its frame parameters (the range its shape covers) set from the data."""
    fields = set(type(effect).model_fields) & FRAME_PARAMETERS
    if not fields:
        return effect
    frame = {"span": max(float(np.max(measurement.signals["strain_nominal"])) * 1.02, 1e-3)}
    force = model.simulate(measurement.signals, measurement.dt_s).get("contact_force_N")
    if force is not None:
        low, high = float(np.min(force)), float(np.max(force))
        frame |= {"low_N": low, "span_N": max(high - low, 1e-3)}
    return effect.near(**{key: frame[key] for key in fields if key in frame})


def without_shapes(model: KnitModel, names: Iterable[str] = SHAPES) -> KnitModel:
    """The model with its base laws unbent: without those of the shapes `names` that it has."""
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
            shape = like[name] if like is not None and name in like else _started(effects[name](), model)
            model = model.plus(framed(shape, model, measurement))
    return model


def _started(shape: Effect, model: KnitModel) -> Effect:
    """A shape where its search starts: at zero, but for Bouc-Wen, whose other parameters do nothing there."""
    if shape.name != "hysteresis_bouc_wen":
        return shape
    friction_N = getattr(model["hysteresis"], "friction_N", 0.1) if "hysteresis" in model else 0.1
    return shape.replaced(friction_N=BOUC_WEN_SHARE * friction_N)
