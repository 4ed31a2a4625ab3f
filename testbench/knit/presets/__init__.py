"""Sensors to start from: knit models whose simulated campaigns behave like published ones.

The JSON files beside this one are written by ``datasets/tune_presets.py``; see docs/effects.md.
"""

from __future__ import annotations

import json
from importlib import resources

from gcode.support.errors import UserError
from testbench.knit.catalogue import load_catalogue, model_from_dict
from testbench.knit.model import KnitModel


def names() -> list[str]:
    """Names of all presets, sorted."""
    files = resources.files(__name__).iterdir()
    return sorted(entry.name.removesuffix(".json") for entry in files if entry.name.endswith(".json"))


def preset(name: str) -> KnitModel:
    """The knit model called `name`.

    Parameters
    ----------
    name : str
        ``"pes"`` (conductive polyester yarn) or ``"lycra"`` (with elastane); see `names`.

    Raises
    ------
    UserError
        If there is no such preset.
    """
    if name not in names():
        raise UserError(f"no sensor preset called {name}; there are {', '.join(names())}")
    data = json.loads(resources.files(__name__).joinpath(f"{name}.json").read_text(encoding="utf-8"))
    return model_from_dict(data, load_catalogue(), source=f"preset {name}")
