"""The catalogue: name of an effect -> its class. A new built-in effect is one line in `BUILT_IN`."""

from __future__ import annotations

import importlib
import importlib.util
from dataclasses import dataclass, field
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from gcode.support.errors import UserError, first_problem
from testbench.knit.effect import Effect
from testbench.knit.model import FORMAT, FORMAT_VERSION, KnitModel

BUILT_IN = {
    # the baseline
    "elasticity": "testbench.knit.elasticity:Elasticity",
    "hysteresis": "testbench.knit.hysteresis:Hysteresis",
    "contact": "testbench.knit.contact:Contact",
    "drift": "testbench.knit.electrical:Drift",
}
BASELINE = ("elasticity", "hysteresis", "contact", "drift")
ENTRY_POINT_GROUP = "knitbench.effects"


@dataclass
class Catalogue:
    """Effects by name, and what could not be loaded.

    Attributes
    ----------
    effects : dict of str to type of Effect
    broken : dict of str to str
        Plug-ins that failed to load, with the reason. They are listed, never a crash.
    """

    effects: dict[str, type[Effect]] = field(default_factory=dict)
    broken: dict[str, str] = field(default_factory=dict)

    def __getitem__(self, name: str) -> type[Effect]:
        try:
            return self.effects[name]
        except KeyError:
            raise UserError(f"no effect called {name}; `testbench effects` lists them all") from None

    def ideas(self) -> dict[str, list[type[Effect]]]:
        """Effects grouped by physical idea: the name of the idea -> its forms, the namesake first."""
        groups: dict[str, list[type[Effect]]] = {}
        for effect in self.effects.values():
            groups.setdefault(effect.idea or effect.name, []).append(effect)
        return groups


def load_catalogue(user_file: str | Path | None = None) -> Catalogue:
    """Built-in effects, installed plug-ins and, where given, a user's own file.

    Raises
    ------
    UserError
        If `user_file` cannot be loaded: the user asked for it by name, so it must not be skipped silently.
    """
    catalogue = Catalogue()
    for name, target in BUILT_IN.items():
        module, _, attribute = target.partition(":")
        catalogue.effects[name] = getattr(importlib.import_module(module), attribute)
    for point in entry_points(group=ENTRY_POINT_GROUP):
        try:
            catalogue.effects[point.name] = point.load()
        except Exception as error:  # a broken plug-in is somebody else's bug: list it
            catalogue.broken[point.name] = f"{type(error).__name__}: {error}"
    if user_file is not None:
        catalogue.effects.update(_effects_in_file(Path(user_file)))
    return catalogue


def _effects_in_file(path: Path) -> dict[str, type[Effect]]:
    if not path.is_file():
        raise UserError(f"{path}: no such effects file; `testbench effects --new NAME` writes a template")
    spec = importlib.util.spec_from_file_location(f"knitbench_user_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise UserError(f"{path}: cannot be loaded: {type(error).__name__}: {error}") from error
    found = {
        value.name: value
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, Effect) and value.__module__ == module.__name__
    }
    if not found:
        raise UserError(f"{path}: no Effect class in it; `testbench effects --new NAME` writes a template")
    return found


def model_from_dict(data: Any, catalogue: Catalogue, source: str = "model") -> KnitModel:
    """Rebuild a model from `KnitModel.to_dict`.

    Raises
    ------
    UserError
        For another format or version, unknown effects, unknown parameters or values out of bounds.
    """
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise UserError(f"{source}: not a knitbench model (its format must be {FORMAT!r})")
    if data.get("version") != FORMAT_VERSION:
        raise UserError(f"{source}: model version {data.get('version')!r}; this knitbench reads {FORMAT_VERSION}")
    model = KnitModel()
    try:
        for entry in data["effects"]:
            effect = catalogue[entry["effect"]].model_validate(entry["parameters"])
            model = model.plus(effect, entry["name"])
    except UserError as error:
        raise UserError(f"{source}: {error}") from None
    except (KeyError, TypeError) as error:
        raise UserError(f"{source}: malformed list of effects ({error})") from None
    except ValueError as error:
        raise UserError(f"{source}: effect {entry['name']}: {first_problem(error)}") from None
    return model


def baseline() -> KnitModel:
    """The model that every diagnosis starts from, with default parameters."""
    effects = load_catalogue().effects
    return KnitModel.of(*(effects[name]() for name in BASELINE))
