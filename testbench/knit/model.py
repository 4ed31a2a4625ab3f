"""KnitModel: an ordered set of named effects that turns a motion into force and conductance."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from gcode.support.errors import UserError
from gcode.support.html import table
from gcode.support.read_only import ReadOnly, Unchanging
from testbench.knit.additive import AdditiveLaw
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import Effect, FloatArray, Signals, Stage, bounds_of, is_ours, remedy, watched

if TYPE_CHECKING:
    import pandas as pd

FORMAT = "knitbench-model"
FORMAT_VERSION = 1
ADDRESS = re.compile(r"([^.]+)\.(\w+)(?:\[(\d{1,9})\])?")


@dataclass(frozen=True)
class KnitModel(Unchanging):
    """Ordered, named effects.

    Attributes
    ----------
    effects : mapping of str to Effect
        In the order of application. The key is the effect's name in this model: the catalogue's name, or
        ``name_2`` for a second instance of the same effect.

    Examples
    --------
    >>> import testbench as tb
    >>> model = tb.baseline() + tb.effects.StressRelaxation(fraction=0.2)
    >>> model["stress_relaxation"].fraction
    0.2
    """

    effects: Mapping[str, Effect] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.effects, Mapping):
            raise UserError(
                f"KnitModel: effects must be a mapping of names to effects, got {type(self.effects).__name__}; "
                "testbench.KnitModel.of(effect, ...) names them itself"
            )
        for name, effect in self.effects.items():
            if not (isinstance(name, str) and isinstance(effect, Effect)):
                raise UserError(
                    f"KnitModel: {name!r} must name an effect, as testbench.effects.StressRelaxation(fraction=0.2), "
                    f"got {type(effect).__name__}"
                )
            if not name.isprintable() or "." in name or not name:
                raise UserError(f"KnitModel: an effect's name must be printable, without a point; got {name!r}")
        # What is in it is frozen itself, and a fit makes many models.
        object.__setattr__(self, "effects", ReadOnly(self.effects))

    @classmethod
    def of(cls, *effects: Effect) -> KnitModel:
        """Build a model from effects, each put where `plus` puts it."""
        model = cls()
        for effect in effects:
            model = model.plus(effect)
        return model

    def __iter__(self) -> Iterator[str]:
        return iter(self.effects)

    def __len__(self) -> int:
        return len(self.effects)

    def __contains__(self, name: str) -> bool:
        return name in self.effects

    def __getitem__(self, name: str) -> Effect:
        try:
            return self.effects[name]
        except (KeyError, TypeError):  # the second: of what no dict can hold, such as a list of names
            raise UserError(f"the model has no effect {name}; it has {', '.join(self.effects)}") from None

    def plus(self, effect: Effect, name: str | None = None) -> KnitModel:
        """A model with `effect` at the end of its stage, a law of the base at the end of those that its stage has.

        An effect so acts on all that the base does, whichever of them came first. A law takes the place of another of
        the same mechanism; so does a law that makes a signal (conductance from the strain) of another that makes it
        (from contacts). A model knows no recording: of an effect on what was not measured, a fit says that the
        recording cannot tell.

        Parameters
        ----------
        effect : Effect
        name : str, optional
            Its name in the model; default: the effect's own, with a number behind it where that is taken.

        Raises
        ------
        UserError
            If it is no effect, or the model has an effect of this name already.
        """
        if not isinstance(effect, Effect):
            raise UserError(
                f"model + {effect!r}: must be an effect, as testbench.effects.StressRelaxation(fraction=0.2)"
            )
        place = "" if name else self.place_of(type(effect))
        if place:
            return self.replacing(place, effect)
        name = name or self._free_name(effect.name)
        if name in self.effects:
            raise UserError(f"the model already has an effect {name}")
        made = _makes(type(effect))
        rival = next((key for key, one in self.effects.items() if made & _makes(type(one))), "")
        if rival:  # what changes the signal comes after what makes it
            there = self.replacing(rival, effect).effects
            return KnitModel({name if key == rival else key: one for key, one in there.items()})
        items = list(self.effects.items())
        before = (number for number, (_, one) in enumerate(items, 1) if _order(one) <= _order(effect))
        items.insert(max(before, default=0), (name, effect))
        return KnitModel(dict(items))

    def __add__(self, effect: Effect) -> KnitModel:
        return self.plus(effect)

    def place_of(self, law: type[Effect]) -> str:
        """Name of the law whose place `law` takes, since a model has one of the kind; empty if there is none."""
        if not _exclusive(law):
            return ""
        laws = {name: effect for name, effect in self.effects.items() if _exclusive(type(effect))}
        return next((name for name, effect in laws.items() if effect.mechanism == law.mechanism), "")

    def _free_name(self, base: str) -> str:
        name, number = base, 1
        while name in self.effects:
            number += 1
            name = f"{base}_{number}"
        return name

    def without(self, name: str) -> KnitModel:
        """A model without the effect called `name`; a `UserError` says which there are where it has none."""
        self[name]
        return KnitModel({key: value for key, value in self.effects.items() if key != name})

    def replacing(self, name: str, effect: Effect) -> KnitModel:
        """A model with `effect` in the place of the effect called `name`; a `UserError` says so where it has none."""
        self[name]
        return KnitModel({key: effect if key == name else value for key, value in self.effects.items()})

    def with_parameters(self, values: Mapping[str, Any]) -> KnitModel:
        """A model with parameters changed.

        Parameters
        ----------
        values : mapping of str to number
            By address: ``effect.parameter``, in a vector ``effect.parameter[2]``.

        Raises
        ------
        UserError
            If there is no such effect or parameter, or a value lies outside its bounds.
        """
        if not hasattr(values, "items"):  # a Series of pandas has them
            raise UserError(f"with_parameters: must be a mapping of addresses to numbers, got {values!r}")
        places = {parts_of(address): value for address, value in values.items()}
        for name, key, index in places:
            vector = getattr(self[name], key, None)
            if index >= 0 and not (isinstance(vector, tuple) and index < len(vector)):
                raise UserError(f"with_parameters: {name}.{key} has no number [{index}]; it is {vector!r}")
        changed = self.with_places(places.items()).effects
        return KnitModel({**changed, **{name: changed[name].replaced() for name, _, _ in places}})

    def with_places(self, values: Iterable[tuple[tuple[str, str, int | slice], Any]]) -> KnitModel:
        """A model with parameters changed, by their places (see `parts_of`), to values that are allowed.

        A slice of a vector is a place, too.
        """
        changes: dict[str, dict[str, Any]] = {}
        for (effect, key, index), value in values:
            change = changes.setdefault(effect, {})
            if isinstance(index, int) and index < 0:
                change[key] = value
                continue
            change[key] = [*change.get(key, getattr(self[effect], key))]
            change[key][index] = value
        effects = dict(self.effects)
        for name, change in changes.items():
            whole = {key: tuple(value) if isinstance(value, list) else value for key, value in change.items()}
            effects[name] = self[name].model_copy(update=whole)
        return KnitModel(effects)

    def simulate(self, signals: Signals, dt_s: float, cache: SimulationCache | None = None) -> dict[str, FloatArray]:
        """Run every effect in order.

        Parameters
        ----------
        signals : mapping of str to ndarray, each shape (n,)
            At least ``strain_nominal``; see `inputs`.
        dt_s : float
            Grid step in seconds.
        cache : SimulationCache, optional
            Keeps the signals after each effect, and what each law added, so that a run with a changed parameter makes
            only what that parameter changes.

        Returns
        -------
        dict of str to ndarray
            All signals, among them ``strain``, ``force_N``, ``conductance_S`` as far as the model makes them.
        """
        state, todo = cache.resume(self.effects, signals) if cache else (dict(signals), self.effects)
        for name, effect in todo.items():
            state = signals_for(effect, state)
            check_wiring(name, effect, state)
            if cache and isinstance(effect, AdditiveLaw) and is_ours(effect):
                state.update(cache.applied(name, effect, state, dt_s))
            else:
                state.update(apply_checked(name, effect, state, dt_s))
            if cache:
                cache.keep(effect, state)
        return state

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: format, version and the effects in order with their parameters."""
        effects = [
            {"name": name, "effect": effect.name, "parameters": effect.model_dump(mode="json")}
            for name, effect in self.effects.items()
        ]
        return {"format": FORMAT, "version": FORMAT_VERSION, "effects": effects}

    def to_frame(self) -> pd.DataFrame:
        """Every number of the model: one row each, by its address (``effect.parameter``), with its unit."""
        import pandas as pd

        rows = {
            f"{name}.{key}" + (f"[{place}]" if isinstance(value, tuple) else ""): (entry, bounds_of(field)["unit"])
            for name, effect in self.effects.items()
            for key, field in type(effect).model_fields.items()
            for value in [getattr(effect, key)]
            for place, entry in enumerate(value if isinstance(value, tuple) else [value])
        }
        frame = pd.DataFrame.from_dict(rows, orient="index", columns=["value", "unit"])
        return frame.rename_axis("parameter")

    def __repr__(self) -> str:
        return f"<KnitModel {' + '.join(self.effects)}>"

    def _repr_html_(self) -> str:
        rows = [
            (name, key, f"{value:.6g}" if isinstance(value, float) else f"{len(value)} weights")
            for name, effect in self.effects.items()
            for key, value in effect.model_dump().items()
        ]
        return table(("effect", "parameter", "value"), rows)


def parts_of(address: str) -> tuple[str, str, int]:
    """Effect, parameter, and index in its vector (-1: it is none) of ``effect.parameter[index]``."""
    parts = ADDRESS.fullmatch(str(address))
    if parts is None:
        raise UserError(f"parameter {address!r}: must be effect.parameter, or effect.parameter[2] of a vector")
    return parts[1], parts[2], int(parts[3] or -1)


def signals_for(effect: Effect, state: Signals) -> dict[str, FloatArray]:
    """What an effect finds: the force presses the contacts as it is, until an effect tells the two apart."""
    if effect.stage >= Stage.PRESSURE and "contact_force_N" not in state and "force_N" in state:
        return {**state, "contact_force_N": state["force_N"]}
    return dict(state)


def check_wiring(name: str, effect: Effect, state: Mapping[str, FloatArray]) -> None:
    """Refuse an effect whose inputs no earlier effect makes."""
    missing = [signal for signal in effect.reads if signal not in state]
    if missing:
        raise UserError(
            f"effect {name} reads {', '.join(missing)}, which nothing before it makes; put a law for it in the model"
        )


def apply_checked(name: str, effect: Effect, state: Mapping[str, FloatArray], dt_s: float) -> Signals:
    """Apply an effect; one that is not ours is watched, for its mistakes would look like findings.

    Raises
    ------
    UserError
        If a user's effect raises, or returns other signals, lengths or values than it should.
    """
    if is_ours(effect):
        return effect.apply(state, dt_s)
    with watched(effect, f"effect {name}"):
        written = effect.apply(state, dt_s)
    if came := strangely_written(effect, written):
        raise UserError(f"effect {name} must return {', '.join(effect.writes)}, got {came}{remedy(effect)}")
    for signal, values in written.items():
        problem = _unusable(values, len(state["time_s"]))
        if problem:
            raise UserError(f"effect {name} returned {signal} {problem} (its parameters: {effect}){remedy(effect)}")
    return written


def strangely_written(effect: Effect, written: object) -> str:
    """What came in the place of the signals that an effect writes; empty where it is those."""
    if not isinstance(written, Mapping):
        return type(written).__name__
    return "" if set(written) == set(effect.writes) else ", ".join(map(str, written)) or "nothing"


def _unusable(values: object, count: int) -> str:
    """What is wrong with a returned signal; empty if nothing."""
    if not isinstance(values, np.ndarray):
        return f"as {type(values).__name__} instead of an array"
    if values.shape != (count,):
        return f"of shape {values.shape} instead of ({count},)"
    if values.dtype.kind not in "fiu":
        return f"of type {values.dtype} instead of float"
    bad = int(np.count_nonzero(~np.isfinite(values)))
    return f"with {bad} values that are not finite" if bad else ""


def inputs(
    time_s: FloatArray, strain_nominal: FloatArray, temperature_C: FloatArray | None = None
) -> dict[str, FloatArray]:
    """The signals a simulation starts from, on a uniform grid that starts at zero.

    ``strain`` starts as the nominal strain; kinematic effects change it.
    """
    given = {"time_s": time_s, "strain_nominal": strain_nominal, "temperature_C": temperature_C}
    # A column of pandas is read-only, which compiled laws do not take.
    signals = {name: np.require(x, np.float64, ["C", "W"]) for name, x in given.items() if x is not None}
    signals["time_s"] = signals["time_s"] - signals["time_s"][0]
    return {**signals, "strain": signals["strain_nominal"]}


def by_stage(effects: Mapping[str, Effect]) -> KnitModel:
    """A model of these effects in the order of their stages; within a stage in the order in which they are given."""
    return KnitModel(dict(sorted(effects.items(), key=lambda item: item[1].stage)))  # sorted() is stable


def _makes(law: type[Effect]) -> set[str]:
    """Signals that a law makes from others, and does not merely change."""
    return set() if law.strength else set(law.writes) - set(law.reads)


def _order(effect: Effect) -> tuple[int, bool]:
    """What comes before what in a model: by stage, and in each the laws of the base first."""
    return effect.stage, not effect.in_base


def _exclusive(law: type[Effect]) -> bool:
    """Whether a model has one law of this mechanism; one without a strength cannot be absent, nor be there twice."""
    return law.exclusive or not law.strength
