"""An effect: one physical idea, one class, all data in and all data out.

A signal is a whole array on a uniform time grid. An effect reads some signals and returns new arrays for the
ones it writes; it keeps no state between calls and changes nothing in place. Adding an effect to knitbench
takes one class, one line in `catalogue.py`, and no test: the laws in ``tests/testbench/knit/test_laws.py``
hold for every registered effect.

Signals by stage
----------------
=========== ============================================================== =========================
stage       what happens                                                   may write
=========== ============================================================== =========================
KINEMATICS  what strain the knit really sees: backlash, slip, set          ``strain``
MECHANICS   force the knit answers with                                    ``force_N``
PRESSURE    force that presses the contacts (starts as ``force_N``)        ``contact_force_N``
CONTACT     contact force (and strain) to conductance                      ``conductance_S``
ELECTRICAL  what happens to the conductance afterwards                     ``conductance_S``
READOUT     what the instruments make of it                                ``force_N``, ``conductance_S``
=========== ============================================================== =========================

Always there to be read: ``time_s``, ``strain_nominal`` (displacement / gauge length) and, where it was
measured, ``temperature_C``.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Any, ClassVar

from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field
from pydantic.fields import FieldInfo

FloatArray = NDArray[Any]
Signals = Mapping[str, FloatArray]


class Stage(IntEnum):
    """Where in the signal chain an effect acts; the order of the stages is the order of the physics."""

    KINEMATICS = 0
    MECHANICS = 1
    PRESSURE = 2
    CONTACT = 3
    ELECTRICAL = 4
    READOUT = 5


def parameter(
    default: float | tuple[float, ...],
    *,
    unit: str,
    low: float,
    high: float,
    doc: str,
    scale: str = "linear",
    source: str = "",
) -> Any:
    """Declare one parameter of an effect: value, unit, bounds, scale, meaning, source, in one place.

    Validation, fit bounds, JSON schema, command-line help and the web form all read this declaration.

    Parameters
    ----------
    default : float or tuple of float
        Value when nothing is said; a tuple declares a vector whose entries share unit and bounds.
    unit : str
        SI symbol; ``"1"`` for dimensionless.
    low, high : float
        Inclusive bounds. A fit stays within; a value outside is refused.
    scale : {"linear", "log"}
        How a fit should step; ``"log"`` needs ``low > 0``.
    doc, source : str
        What it means, and where its usual value comes from.
    """
    extra = {"unit": unit, "low": low, "high": high, "scale": scale, "source": source}
    if isinstance(default, tuple):
        return Field(default=default, description=doc, json_schema_extra=extra)  # type: ignore[arg-type]
    return Field(default=default, ge=low, le=high, description=doc, json_schema_extra=extra)  # type: ignore[arg-type]


class Effect(BaseModel):
    """Base of all effects. See the module's docstring for what a subclass declares.

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
    idea : str
        Name of the physical idea; several forms of one idea (classes) share it. Empty: the same as `name`.
    look : str
        What a person sees in the data when this effect is there, in one plain sentence.
    optional_reads : tuple of str
        Signals used where present (``temperature_C``).
    nonlinear : bool
        The response has a threshold (a gap, a clipping level), so a small strength says little about a large one:
        try a grid of magnitudes instead of a finite difference at zero.
    imitated_by : {"", "elasticity", "contact", "slip"}
        Freedom of the base laws that could imitate the effect, because it depends on the present strain or force
        alone ("elasticity", "contact") or on direction alone ("slip"). The diagnosis then lets the effect stand in
        for that freedom, and prefers it if it does as well with fewer numbers.
    cost : float
        Share of what it explains that a diagnosis takes off, because the effect is rare or imitates others easily (an
        unmeasured room explains any slow drift). Nothing is taken off where all `optional_reads` were measured.
    quick : bool
        What it does may be quicker than the time grid of the diagnosis, which thins it: what it leaves unexplained
        then says nothing against it.
    per_recording : tuple of str
        Parameters that belong to one recording, not to the sensor (the phase of a hum): each has its own.
    akin : tuple of str
        Ideas whose traces agree so nearly that a grid of first-order trials does not tell them: where one of them
        leads, the others are refitted, too.
    absent_at : mapping of str to float
        Parameters, and the values from which on their part of the law is never reached. A recording that does not
        reach it cannot tell how far off it is: a fit stops at the edge, and the next recording may go beyond.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: ClassVar[str] = ""
    stage: ClassVar[Stage]
    reads: ClassVar[tuple[str, ...]]
    writes: ClassVar[tuple[str, ...]]
    strength: ClassVar[str] = ""
    idea: ClassVar[str] = ""
    look: ClassVar[str] = ""
    optional_reads: ClassVar[tuple[str, ...]] = ()
    nonlinear: ClassVar[bool] = False
    imitated_by: ClassVar[str] = ""
    cost: ClassVar[float] = 0.0
    quick: ClassVar[bool] = False
    per_recording: ClassVar[tuple[str, ...]] = ()
    akin: ClassVar[tuple[str, ...]] = ()
    absent_at: ClassVar[Mapping[str, float]] = {}

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

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        """Parameter points worth a try on these data, where a generic grid would miss them; default: none.

        What lies beyond a bound is moved onto it.

        Parameters
        ----------
        signals : mapping of str to ndarray, each shape (n,)
            Everything the model without this effect makes.
        residual : mapping of str to ndarray, each shape (n,)
            Measured minus modelled: ``force`` in N, ``conductance`` in ln S, as far as measured.
        """
        return []

    @property
    def imitable(self) -> bool:
        """Whether a freely bending base law could imitate the effect."""
        return bool(self.imitated_by)

    def for_recording(self, signals: Signals, residual: Signals, dt_s: float) -> Effect:
        """The effect with those `per_recording` parameters that no gradient finds (moments of slips) set from data.

        Arguments as `data_grid`. Default: the effect as it is.
        """
        return self

    def seen(self, signals: Signals, residual: Signals, dt_s: float) -> Effect | None:
        """The effect as the readings themselves show it, whatever the model; None where they do not, or never can.

        Arguments as `data_grid`. A reading that stands at exactly one extreme value for thousands of samples is cut
        off, however well a bent law may follow it.
        """
        return None

    def initial_guess(self, signals: Signals, dt_s: float) -> Effect:
        """A start for a fit, made from measured ``force_N``, ``conductance_S`` and ``strain``.

        Sets parameters whose scale only the data know: a clipping level, an onset of strain, a frequency. Signals
        that were not measured may be missing. The default start keeps the default parameters.
        """
        return self

    def model_post_init(self, _context: Any) -> None:
        for key, field in type(self).model_fields.items():
            check_bounds(type(self), key, field, getattr(self, key))

    def replaced(self, **changes: Any) -> Effect:
        """A copy with some parameters changed, validated."""
        return type(self).model_validate({**self.model_dump(), **changes})

    def near(self, **changes: Any) -> Effect:
        """A copy with some parameters changed, each moved into its bounds: for guesses from data."""
        return self.replaced(**{key: self._into_bounds(key, value) for key, value in changes.items()})

    def _into_bounds(self, key: str, value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(self._into_bounds(key, entry) for entry in value)
        extra = bounds_of(type(self).model_fields[key])
        return min(max(float(value), extra["low"]), extra["high"])


def check_bounds(owner: type[Effect], key: str, field: FieldInfo, value: Any) -> None:
    """Check vector entries too (pydantic's own bounds cover scalars)."""
    if not isinstance(value, tuple):
        return
    extra = bounds_of(field)
    for index, entry in enumerate(value):
        if not extra["low"] <= entry <= extra["high"]:
            allowed = f"[{extra['low']:g}, {extra['high']:g}]"
            raise ValueError(f"{owner.name}.{key}[{index}] must be in {allowed}, got {entry:g}")


def bounds_of(field: FieldInfo) -> dict[str, Any]:
    """Unit, bounds, scale and source as declared by `parameter`."""
    extra = field.json_schema_extra
    assert isinstance(extra, dict), "declare effect parameters with parameter(...)"
    return extra
