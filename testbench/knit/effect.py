"""An effect: one law of one mechanism, one class, all data in and all data out.

A signal is a whole array on a uniform time grid. An effect reads some signals and returns new arrays for the
ones it writes; it keeps no state between calls and changes nothing in place. Adding an effect to knitbench
takes one class, its name in `catalogue.py`, and no test: the rules in ``tests/testbench/knit/test_rules.py``
hold for every registered effect.

Signals by stage
----------------
=========== ============================================================== =========================
stage       what happens                                                   may write
=========== ============================================================== =========================
KINEMATICS  what strain the knit really sees: backlash, slip, set          ``strain``
MECHANICS   force the knit answers with                                    ``force_N``
TENSION     a thin fabric buckles rather than pushes                       ``force_N``
PRESSURE    force that presses the contacts (starts as ``force_N``)        ``contact_force_N``
CONTACT     contact force (and strain) to conductance                      ``conductance_S``
ELECTRICAL  what happens to the conductance afterwards                     ``conductance_S``
READOUT     what the instruments make of it                                ``force_N``, ``conductance_S``
=========== ============================================================== =========================

Always there to be read: ``time_s`` and ``strain_nominal`` (displacement / gauge length). ``temperature_C`` is there
only where it was measured, ``clamping`` (how often the knit was clamped anew) only where it was: they belong in
`optional_reads`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from enum import IntEnum
from typing import Any, ClassVar, NoReturn, get_origin

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic.fields import FieldInfo

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from gcode.support.kinds import is_number, only_by_name

Signals = Mapping[str, FloatArray]
Points = list[dict[str, Any]]  # of parameters, where a fit may start
Vector = tuple[float, ...]  # of numbers that share unit and bounds
OURS = "testbench.knit."  # effects from elsewhere are watched, for their mistakes would look like findings


class Stage(IntEnum):
    """Where in the signal chain an effect acts; the order of the stages is the order of the physics."""

    KINEMATICS = 0
    MECHANICS = 1
    TENSION = 2
    PRESSURE = 3
    CONTACT = 4
    ELECTRICAL = 5
    READOUT = 6


def parameter(
    default: float | tuple[float, ...],
    *,
    unit: str,
    low: float,
    high: float,
    doc: str,
    scale: str = "linear",
    typical: float | None = None,
) -> Any:
    """Declare one parameter of an effect: value, unit, bounds, scale, meaning, in one place.

    Validation, fit bounds, JSON schema, command-line help and the web form all read this declaration.

    Parameters
    ----------
    default : float or tuple of float
        Value when nothing is said, and the centre of a diagnosis's prior; a tuple declares a vector whose entries
        share unit and bounds. It has as many numbers, or any number of them where the tuple has one.
    unit : str
        SI symbol; ``"1"`` for dimensionless.
    low, high : float
        Inclusive bounds. A fit stays within; a value outside is refused.
    scale : {"linear", "log"}
        How a fit should step; ``"log"`` needs ``low > 0``.
    doc : str
        What it means.
    typical : float, optional
        Of a strength: its usual size, the width of its prior around zero; in N, as a share of the range of the force.
        Default: `default`, or a tenth of that range. Of another linear parameter: the standard deviation of its prior
        around `default`; else that is a quarter of its range (with ``"log"``: of the logarithm's, at least 0.5).

    Examples
    --------
    >>> import testbench as tb
    >>> class Stiffer(tb.Effect):
    ...     name, stage, strength = "stiffer", tb.Stage.MECHANICS, "share"
    ...     reads, writes = ("force_N",), ("force_N",)
    ...     share: float = tb.parameter(0.1, unit="1", low=0, high=1, doc="by how much of itself the force is larger")
    ...     def apply(self, signals, dt_s):
    ...         return {"force_N": signals["force_N"] * (1 + self.share)}
    >>> Stiffer().share
    0.1
    """
    if scale not in ("linear", "log") or not (0.0 if scale == "log" else -np.inf) < low < high < np.inf:
        raise UserError(
            f'parameter ({doc}): must have a scale of "linear" or "log", and finite bounds, low < high, above 0 with '
            f'"log"; got scale={scale!r}, low={low!r}, high={high!r}'
        )
    extra = {"unit": unit, "low": low, "high": high, "scale": scale, "typical": typical}
    if isinstance(default, tuple):
        return Field(default=default, description=doc, json_schema_extra=extra)  # type: ignore[arg-type]
    return Field(default=default, ge=low, le=high, description=doc, json_schema_extra=extra)  # type: ignore[arg-type]


def zeros(count: int, *, unit: str, most: float, doc: str, typical: float | None = None) -> Any:
    """Declare a vector of `count` numbers from -`most` to `most` that are 0 when nothing is said; see `parameter`."""
    return parameter((0.0,) * count, unit=unit, low=-most, high=most, doc=doc, typical=typical)


class Effect(BaseModel):
    """Base of all effects; docs/adding-an-effect.md shows one, with what it declares.

    Class attributes
    ----------------
    name : str
        The catalogue's name; snake_case.
    stage : Stage
    reads, writes : tuple of str
        Signals by name. ``apply`` may use only what it reads and must return exactly what it writes.
    strength : str
        The parameter whose value 0 makes the effect the identity; ``""`` for laws that have no such parameter
        (an elastic law cannot be absent).
    mechanism : str
        What happens physically; several laws (classes) of one mechanism share it, mostly through a base class. Not
        said: the same as `name`.
    look : str
        What a person sees in the data when this effect is there, in one plain sentence.
    optional_reads : tuple of str
        Signals used where present (``temperature_C``, ``clamping``).
    nonlinear : bool
        The response has a threshold (a gap, a clipping level), so a small strength says little about a large one:
        try a grid of magnitudes instead of a finite difference at zero.
    jumps : tuple of str
        Parameters at which the response jumps (the moment of a slip): a small change of one moves no sample, or a
        whole one, so that no derivative says how well data know it.
    pointwise : tuple of str
        Signals that it reads and does not remember: what it writes at a moment depends on them at that moment alone.
    per_recording : tuple of str
        Parameters that belong to one recording, not to the sensor (the phase of a hum): each has its own.
    looks_ahead : bool
        May show what is still to come by the time of the others, as an instrument does whose clock is fast.
    bends_a_law : bool
        What it changes in a reading depends on the strain, or on the load of the contacts, alone: a law of the base
        that is not quite the sensor's looks the same.
    in_base : bool
        The base of every model does what it does, or may: nobody looks for it as an effect.
    also_from : tuple of mapping
        Points of its parameters from which a fit begins once more where it has ended elsewhere: no small step leads
        there.
    exclusive : bool
        A model has one law of this mechanism, and another takes its place; so it is with laws that have no strength.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True)

    name: ClassVar[str] = ""
    stage: ClassVar[Stage]
    reads: ClassVar[tuple[str, ...]]
    writes: ClassVar[tuple[str, ...]]
    strength: ClassVar[str] = ""
    mechanism: ClassVar[str] = ""
    look: ClassVar[str] = ""
    optional_reads: ClassVar[tuple[str, ...]] = ()
    nonlinear: ClassVar[bool] = False
    jumps: ClassVar[tuple[str, ...]] = ()
    pointwise: ClassVar[tuple[str, ...]] = ()
    per_recording: ClassVar[tuple[str, ...]] = ()
    looks_ahead: ClassVar[bool] = False
    bends_a_law: ClassVar[bool] = False
    in_base: ClassVar[bool] = False
    also_from: ClassVar[tuple[Mapping[str, float], ...]] = ()
    exclusive: ClassVar[bool] = False
    undeclared: ClassVar[tuple[str, ...]] = ()  # what a class has to say of itself, and does not

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        super().__pydantic_init_subclass__(**kwargs)
        if cls.name and not cls.mechanism:  # a part of classes has neither, and says nothing of it
            cls.mechanism = cls.name
        lists = ("reads", "writes", "optional_reads", "jumps", "pointwise", "per_recording", "also_from")
        kinds = {"stage": Stage, **dict.fromkeys(lists, tuple), **dict.fromkeys(("strength", "look"), str)}
        said = [name for name, kind in kinds.items() if not isinstance(getattr(cls, name, None), kind)]
        fields = cls.model_fields.items()
        cls.undeclared = (*said, *(key for key, field in fields if hasattr(Effect, key) or not _is_parameter(field)))

    def __init__(self, *unnamed: Any, **parameters: Any) -> None:
        """Raise `UserError` where a parameter is unknown or unnamed, or a value is no number or out of its bounds.

        So, too, where the class does not declare where it acts, or on what.
        """
        only_by_name(type(self), "parameters", unnamed)
        if self.undeclared:
            raise UserError(
                f"{type(self).__name__}: the class must declare its stage (a testbench.Stage), what it reads and "
                "writes and whatever else has several names (tuples), and its parameters (each a float or a "
                "tuple[float, ...], by testbench.parameter, under a name that Effect does not use); amiss: "
                + ", ".join(self.undeclared)
            )
        try:
            super().__init__(**parameters)
        except ValidationError as error:
            raise UserError(_refusal(type(self), error)) from None
        for key, field in type(self).model_fields.items():
            value = getattr(self, key)
            if isinstance(value, tuple):
                # One number alone stands for as many as there are recordings.
                if 1 < (count := len(field.default)) != len(value):
                    raise UserError(
                        f"{type(self).__name__}.{key} must be {count} numbers, got {len(value)}; a model of another "
                        "version is to be fitted again"
                    )
                bounds = bounds_of(field)
                if value and not (bounds["low"] <= min(value) and max(value) <= bounds["high"]):
                    raise UserError(_allowed(type(self), key, value))

    def __add__(self, other: object) -> NoReturn:
        raise UserError(
            f"{type(self).__name__} + ...: effects are put into a model: testbench.baseline() + effect, or "
            "testbench.KnitModel.of(effect, effect)"
        )

    __radd__ = __add__

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        """Return new arrays for the signals in `writes`.

        Parameters
        ----------
        signals : mapping of str to ndarray, each shape (n,)
            Read-only; on a uniform grid.
        dt_s : float
            Grid step in seconds.
        """
        raise NotImplementedError

    def of_one_recording(self, signals: Signals) -> tuple[str, ...]:
        """Parameters that belong to the recording with these signals, not to the sensor; default: `per_recording`."""
        return self.per_recording

    def is_a_bend(self, signals: Signals) -> bool:
        """Whether a law of the base that is not quite the sensor's would look the same in this motion."""
        return self.bends_a_law

    def starts(self, signals: Signals, residual: Signals) -> Points:
        """Points of the parameters where a fit may start on these data; default: none, a coarse grid of the bounds.

        What lies beyond a bound is moved onto it; parameters that a point leaves out stay as they are.

        Parameters
        ----------
        signals : mapping of str to ndarray, each shape (n,)
            Everything the model without this effect makes, or the measured signals; with ``time_s``.
        residual : mapping of str to ndarray, each shape (n,)
            Measured minus `signals`: ``force`` in N, ``conductance`` in ln S, as far as measured.
        """
        return []

    def unfolded(self, grid_Hz: float, highest_Hz: float) -> list[Effect]:
        """The same at the frequencies, up to a highest one, that a grid of samples folds to its own; default: none.

        Samples that are left out may hide that a disturbance is quicker than they are (Shannon's sampling theorem).
        """
        return []

    def started(self, signals: Signals, residual: Signals) -> Effect:
        """The effect at the first of its `starts`, or as it is where it has none; arguments as there."""
        points = self.starting_points(signals, residual)
        return self.near(**points[0]) if points else self

    def starting_points(self, signals: Signals, residual: Signals) -> Points:
        """The `starts` on these data; a mistake in those of a user's own effect is told in a sentence."""
        with nullcontext() if is_ours(self) else watched(self, f"effect {self.name}: starts"):
            return self.starts(signals, residual)

    def replaced(self, **changes: Any) -> Effect:
        """A copy with some parameters changed, validated."""
        return type(self)(**{**dict(self), **changes})

    def near(self, **changes: Any) -> Effect:
        """A copy with some parameters changed, each moved into its bounds: for guesses from data."""
        return self.replaced(**{key: self._into_bounds(key, value) for key, value in changes.items()})

    def _into_bounds(self, key: str, value: Any) -> Any:
        if isinstance(value, tuple | list):
            return tuple(self._into_bounds(key, entry) for entry in value)
        if key not in type(self).model_fields or not is_number(value):
            return value  # which `replaced` refuses
        extra = bounds_of(type(self).model_fields[key])
        return min(max(float(value), extra["low"]), extra["high"])


def _is_parameter(field: FieldInfo) -> bool:
    """Whether a field is declared by `parameter`, as a number or as a vector of numbers: no fit can take others."""
    kind = tuple if isinstance(field.default, tuple) else float
    return isinstance(field.json_schema_extra, dict) and (get_origin(field.annotation) or field.annotation) is kind


def _refusal(effect: type[Effect], error: ValidationError) -> str:
    """Which parameter, what is allowed, what came."""
    problem = error.errors(include_url=False)[0]
    key = str(problem["loc"][0])
    if key in effect.model_fields:
        return _allowed(effect, key, problem["input"])
    return f"{effect.__name__} has no parameter {key}; it has {', '.join(effect.model_fields) or 'none'}"


def _allowed(effect: type[Effect], key: str, came: Any) -> str:
    field = effect.model_fields[key]
    bounds = bounds_of(field)
    kind = "numbers" if isinstance(field.default, tuple) else "a number"
    unit = "" if bounds["unit"] == "1" else f" {bounds['unit']}"
    return f"{effect.__name__}.{key} must be {kind} from {bounds['low']:g} to {bounds['high']:g}{unit}, got {came!r}"


def bounds_of(field: FieldInfo) -> dict[str, Any]:
    """Unit, bounds, scale and typical size as declared by `parameter`."""
    extra = field.json_schema_extra
    assert isinstance(extra, dict), "declare effect parameters with parameter(...)"
    return extra


def is_ours(effect: Effect) -> bool:
    """Whether it is a built-in one; others are watched."""
    return type(effect).__module__.startswith(OURS)


@contextmanager
def watched(effect: Effect, what: str) -> Iterator[None]:
    """Whatever a user's effect raises becomes one sentence that begins with `what`."""
    try:
        yield
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # sys.exit would end the command as if all were well
        raise UserError(f"{what} raised {type(error).__name__}: {error}{remedy(effect)}") from error


def remedy(effect: Effect) -> str:
    """What to do about a mistake of somebody's effect."""
    return f"; mend it and try `testbench effects {effect.name} --effects FILE.py --check`"


def step_s(signals: Signals) -> float:
    """Step of the time grid in seconds."""
    time_s = signals["time_s"]
    return float(time_s[-1] - time_s[0]) / max(len(time_s) - 1, 1)
