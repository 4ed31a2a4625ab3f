"""Rules that every effect keeps, built in or a user's own: ``testbench effects --check --effects my_effects.py``.

Each rule takes an effect with its parameters and returns "" or what is wrong, in one sentence.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterator

import numpy as np

from gcode.support.errors import UserError, first_problem
from gcode.support.read_only import ReadOnly
from testbench.knit.additive import AdditiveLaw
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.knit.effect import Effect, FloatArray, Signals, Stage, bounds_of
from testbench.knit.filters import LARGEST_LOG_CHANGE
from testbench.knit.model import strangely_written

WRITABLE = {
    Stage.KINEMATICS: {"strain"},
    Stage.MECHANICS: {"force_N"},
    Stage.TENSION: {"force_N"},
    Stage.PRESSURE: {"contact_force_N"},
    Stage.CONTACT: {"conductance_S"},
    Stage.ELECTRICAL: {"conductance_S"},
    Stage.READOUT: {"force_N", "conductance_S"},
}
# What a law may read: what there is from the start, and what stages up to its own write.
READABLE = {
    stage: {"time_s", "strain_nominal"}.union(*(names for before, names in WRITABLE.items() if before <= stage))
    for stage in Stage
}
NOT_ALWAYS_THERE = {"temperature_C", "clamping"}
CHECKED_S = 60.0
Rule = Callable[[Effect], str]


class OnlyDeclared(ReadOnly[str, FloatArray]):
    """Signals of which only the declared ones can be read."""

    def __missing__(self, key: str) -> FloatArray:
        raise KeyError(f"{key} is not among what it reads")


def example_signals(dt_s: float) -> dict[str, FloatArray]:
    """Smooth, lively signals given by formulas, so that every sampling rate sees the same motion."""
    t = np.arange(round(CHECKED_S / dt_s) + 1) * dt_s
    strain = 0.16 + 0.1 * np.sin(1.3 * t - 1.5) + 0.06 * np.sin(0.37 * t - 1.5)
    force = 6 * strain + 15 * strain**2
    return {
        "time_s": t,
        "strain_nominal": strain,
        "strain": strain.copy(),
        "force_N": force,
        "contact_force_N": force.copy(),
        "conductance_S": 1e-6 * (1 + force),
        "temperature_C": 23 + 2 * np.sin(t / 7),
    }


def applied(effect: Effect, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
    """What the effect makes of the signals, given only those that it declares; `UserError` where it is others."""
    declared = {key: value for key, value in signals.items() if key in effect.reads + effect.optional_reads}
    out = effect.apply(OnlyDeclared(declared), dt_s)
    if came := strangely_written(effect, out):
        raise UserError(f"returns {came}, but declares {', '.join(effect.writes)}")
    return out


def declares_itself(effect: Effect) -> str:
    """Look, docstring with source and validity; units and bounds of every parameter; a fitting stage."""
    cls = type(effect)
    doc = cls.__doc__ or ""
    missing = [word for word in ("Source:", "Valid:") if word not in doc]
    if missing or not cls.look:
        return f"needs a `look` and a docstring with {' and '.join(missing) or 'Source: and Valid:'}"
    if not set(cls.writes) <= WRITABLE[cls.stage]:
        return f"writes {', '.join(cls.writes)}, but stage {cls.stage.name} may write {sorted(WRITABLE[cls.stage])}"
    unknown = (set(cls.reads) | set(cls.optional_reads) - NOT_ALWAYS_THERE) - READABLE[cls.stage]
    if unknown:
        return f"reads {', '.join(sorted(unknown))}, which does not exist in stage {cls.stage.name}"
    return _check_parameters(cls)


def _check_parameters(cls: type[Effect]) -> str:
    for key, field in cls.model_fields.items():
        if not (bounds_of(field)["unit"] and field.description):
            return f"parameter {key} needs a unit and a doc"
    named = {"jumps": cls.jumps, "per_recording": cls.per_recording, "also_from": itertools.chain(*cls.also_from)}
    for what, keys in (named | {"strength": [cls.strength] if cls.strength else []}).items():
        if strange := sorted(set(keys) - set(cls.model_fields)):
            return f"{what} names {strange[0]}, which is not a parameter"
    if cls.strength:
        extra = bounds_of(cls.model_fields[cls.strength])
        if not extra["low"] <= 0 <= extra["high"]:
            return f"the bounds of the strength {cls.strength} must include 0, which means: no effect"
    return ""


def leaves_inputs_alone(effect: Effect) -> str:
    """No input array is changed, and none is handed back as an output."""
    signals = example_signals(0.05)
    copies = {key: value.copy() for key, value in signals.items()}
    out = applied(effect, signals, 0.05)
    changed = [key for key in signals if not np.array_equal(signals[key], copies[key])]
    if changed:
        return f"changes its input {', '.join(changed)} in place; return a new array instead"
    shared = [key for key in out if any(np.shares_memory(out[key], value) for value in signals.values())]
    return f"returns an input array as {', '.join(shared)}; return a copy" if shared else ""


def returns_what_it_declares(effect: Effect) -> str:
    """Exactly the signals in `writes`, as float64 arrays of the same length."""
    signals = example_signals(0.05)
    needed = signals["time_s"].shape
    for key, value in applied(effect, signals, 0.05).items():
        kind = getattr(value, "dtype", type(value).__name__)
        if kind != np.float64 or np.shape(value) != needed:
            return f"{key} has shape {np.shape(value)} and type {kind}; needed: an array of float64, {needed}"
    return ""


def stays_finite(effect: Effect) -> str:
    """No NaN or infinity: for usual signals, extreme ones, a still knit and a single sample."""
    usual = example_signals(0.05)
    for what, signals in {
        "usual signals": usual,
        "extreme signals": _extreme(usual),
        "a still knit": {
            key: value if key == "time_s" else np.full_like(value, value[0]) for key, value in usual.items()
        },
        "a single sample": {key: value[:1] for key, value in usual.items()},
    }.items():
        for key, value in applied(effect, signals, 0.05).items():
            if not np.all(np.isfinite(value)):
                return f"{key} is not finite for {what}"
    return ""


def stays_finite_at_its_bounds(effect: Effect) -> str:
    """No NaN or infinity where a parameter is as small or as large as it may be, one after the other."""
    signals = example_signals(0.05)
    for key, field in type(effect).model_fields.items():
        if not isinstance(field.default, int | float):
            continue
        for side in ("low", "high"):
            at = effect.replaced(**{key: bounds_of(field)[side]})
            for signal, values in applied(at, signals, 0.05).items():
                if not np.all(np.isfinite(values)):
                    return f"{signal} is not finite with {key} at its bound {bounds_of(field)[side]:g}"
    return ""


def _extreme(signals: Signals) -> dict[str, FloatArray]:
    wild = dict(signals)
    wild["strain"] = wild["strain_nominal"] = 5 * signals["strain"] - 0.5
    wild["force_N"] = wild["contact_force_N"] = 100 * signals["force_N"] - 50
    return wild


def has_vector_strength(effect: Effect) -> bool:
    """Whether the strength is a set of weights."""
    return bool(effect.strength) and isinstance(getattr(effect, effect.strength), tuple)


def absent(effect: Effect) -> Effect:
    """The effect at zero strength; where that is a set of weights, any others are as by themselves."""
    if has_vector_strength(effect):
        return type(effect)(**{effect.strength: (0.0,) * len(getattr(effect, effect.strength))})
    return effect.replaced(**{effect.strength: 0.0})


def is_nothing_at_zero_strength(effect: Effect) -> str:
    """With its strength at 0 the effect changes nothing."""
    if not effect.strength:
        return ""
    signals = example_signals(0.05)
    for key, value in applied(absent(effect), signals, 0.05).items():
        error = np.max(np.abs(value - signals[key])) / np.max(np.abs(signals[key]))
        if error > 1e-9:
            return f"changes {key} by {error:.2g} of its size although {effect.strength} is 0"
    return ""


def grows_smoothly_from_zero(effect: Effect) -> str:
    """Twice a small strength does twice as much (unless the effect declares itself `nonlinear`)."""
    if not effect.strength or effect.nonlinear or has_vector_strength(effect):
        return ""
    signals = example_signals(0.05)
    extra = bounds_of(type(effect).model_fields[effect.strength])
    small = 1e-5 * (extra["high"] if extra["high"] > 0 else extra["low"])

    def response(strength: float) -> FloatArray:
        out = applied(effect.replaced(**{effect.strength: strength}), signals, 0.05)
        return np.concatenate([out[key] - signals[key] for key in effect.writes])

    once, twice = response(small), response(2 * small)
    error = float(np.max(np.abs(twice - 2 * once)))
    noise = 1e-12 * max(float(np.max(np.abs(signals[key]))) for key in effect.writes)
    if error <= 0.05 * float(np.max(np.abs(twice))) + noise:
        return ""
    return f"does not grow in proportion to a small {effect.strength}; if it has a threshold, set nonlinear = True"


def _difference(effect: Effect, coarse_s: float, fine_s: float) -> tuple[float, float]:
    """Mean difference at the shared instants, and the size of the response to compare it with."""
    every = round(coarse_s / fine_s)
    signals = example_signals(fine_s)
    fine, coarse = applied(effect, signals, fine_s), applied(effect, example_signals(coarse_s), coarse_s)
    worst, size = 0.0, 1.0
    for key in effect.writes:
        spread = float(np.std(fine[key]))
        response = float(np.mean(np.abs(fine[key] - signals[key]))) if effect.strength else spread
        scale = max(response, 0.02 * spread, 1e-300)
        error = float(np.mean(np.abs(coarse[key] - fine[key][::every])))
        if error / scale > worst / size:
            worst, size = error, scale
    return worst, size


def converges(effect: Effect) -> str:
    """On finer time grids the result settles."""
    coarse, _ = _difference(effect, 0.08, 0.005)
    fine, size = _difference(effect, 0.02, 0.005)
    if fine <= max(0.6 * coarse, 5e-3 * size):
        return ""
    return f"does not settle on finer time grids: error {fine:.3g} at 0.02 s, {coarse:.3g} at 0.08 s"


def ignores_sampling_rate(effect: Effect) -> str:
    """25 Hz and 100 Hz give the same curve."""
    error, size = _difference(effect, 0.04, 0.01)
    if error <= 0.08 * size:
        return ""
    return f"depends on the sampling rate: {error / size:.1%} of its size between 25 and 100 Hz; use dt_s"


def knows_no_future(effect: Effect) -> str:
    """What comes later does not change what was, but for one sample: a rate is a slope to either side.

    (A `per_recording` shape may know how long it is.)
    """
    if effect.per_recording or effect.looks_ahead:
        return ""
    signals = example_signals(0.05)
    half = len(signals["time_s"]) // 2
    out = applied(effect, signals, 0.05)
    early = applied(effect, {key: value[: half + 1] for key, value in signals.items()}, 0.05)
    for key, value in early.items():
        if not np.allclose(value[:half], out[key][:half], rtol=1e-9, atol=0):
            return f"{key} depends on what happens later; a clock that may be fast needs looks_ahead = True"
    return ""


def forgets_what_is_pointwise(effect: Effect) -> str:
    """Of a signal that it calls `pointwise`, one moment changes what it writes at that moment alone."""
    signals = example_signals(0.05)
    out = applied(effect, signals, 0.05)
    for signal in effect.pointwise:
        if signal not in effect.reads + effect.optional_reads:
            return f"calls {signal} pointwise, which it does not read"
        for moment in np.linspace(0, len(signals["time_s"]) - 1, 5).astype(int):
            moved = signals[signal].copy()
            moved[moment] *= 1.5
            for key, value in applied(effect, {**signals, signal: moved}, 0.05).items():
                later = np.delete(value, moment), np.delete(out[key], moment)
                if not np.allclose(*later, rtol=1e-9, atol=0):
                    return f"remembers {signal}, which it calls pointwise: {key} changes at other moments, too"
    return ""


def adds_its_terms(effect: Effect) -> str:
    """Each weight of a vector adds the term that the law tells, to force in N or to ln S."""
    if not isinstance(effect, AdditiveLaw):
        return ""
    signals = example_signals(0.05)
    for key, default in effect:
        terms = effect.terms(key, signals) if isinstance(default, tuple) else None
        if terms is None:
            continue
        one = effect.replaced(**{key: tuple(np.linspace(-0.1, 0.2, len(default)))})
        none = one.replaced(**{key: (0.0,) * len(default)})
        (written,) = effect.writes
        there, here = (law.apply(signals, 0.05)[written] for law in (one, none))
        added, free = there - here, np.ones(len(there), bool)
        if written == "conductance_S":
            added = np.log(there / here)
            free = np.abs(np.log((there, here) / signals[written])).max(axis=0) < 0.99 * LARGEST_LOG_CHANGE
        if not np.allclose(added[free], (np.array(getattr(one, key)) @ terms)[free], rtol=0, atol=1e-5):
            return f"its terms of {key} are not what the weights add"
    return ""


def starts_a_fit(effect: Effect) -> str:
    """Every one of its `starts` sets parameters that the effect has, whichever channels were measured."""
    signals = example_signals(0.05)
    wave = 0.01 * np.sin(signals["time_s"])
    for measured in (("force", "conductance"), ("force",), ("conductance",), ()):
        for point in effect.starts(signals, dict.fromkeys(measured, wave)):
            if unknown := set(point) - set(type(effect).model_fields):
                return f"starts sets {sorted(unknown)[0]}, which is no parameter of it"
            effect.near(**point)
    return ""


def survives_json(effect: Effect) -> str:
    """Parameters written as JSON and read again give the same effect."""
    again = type(effect)(**json.loads(json.dumps(effect.model_dump(mode="json"), allow_nan=False)))
    return "" if again == effect else "is not the same after a round trip through JSON"


RULES: tuple[Rule, ...] = (
    declares_itself,
    leaves_inputs_alone,
    returns_what_it_declares,
    stays_finite,
    stays_finite_at_its_bounds,
    is_nothing_at_zero_strength,
    grows_smoothly_from_zero,
    converges,
    ignores_sampling_rate,
    knows_no_future,
    forgets_what_is_pointwise,
    adds_its_terms,
    starts_a_fit,
    survives_json,
)


def check(effect: Effect) -> list[str]:
    """Broken rules of one effect, as sentences; empty when all is well.

    What it raises while a rule is tried is told with that rule, and once: the other rules would meet it again.
    """
    problems = []
    for rule in RULES:
        try:
            problems.append(rule(effect))
        except KeyboardInterrupt:
            raise
        except UserError as error:
            problems.append(str(error))
            break
        except BaseException as error:  # whatever a user's code raises is the finding
            tried = rule.__name__.replace("_", " ")
            problems.append(f"raises {type(error).__name__}: {first_problem(error)} ({tried})")
            break
    return [problem for problem in problems if problem]


def checked(catalogue: Catalogue, name: str | None = None) -> Iterator[tuple[str, list[str]]]:
    """The effect of this name, else each of the user's own, else each of the catalogue, with the rules it breaks."""
    known = load_catalogue().effects
    own = [effect for effect in catalogue.effects if effect not in known]
    for effect in [name] if name else own or catalogue.effects:
        yield effect, check(catalogue[effect]())
