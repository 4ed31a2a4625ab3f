"""Sensors to start from: knit models whose simulated campaigns behave like published ones.

The JSON files beside this one are written by ``datasets/tune_presets.py``; see docs/effects.md.
"""

from __future__ import annotations

import json
from importlib import resources

from gcode.support.errors import UserError
from testbench.knit.catalogue import load_catalogue, model_from_dict
from testbench.knit.model import KnitModel
from testbench.knit.presets.population import specimen


def names() -> list[str]:
    """Names of all presets, sorted."""
    files = resources.files(__name__).iterdir()
    return sorted(entry.name.removesuffix(".json") for entry in files if entry.name.endswith(".json"))


def preset(name: str) -> KnitModel:
    """The knit model called `name`; ``name@3`` is its third specimen (`testbench.knit.presets.population`).

    Parameters
    ----------
    name : str
        ``"pes"`` (conductive polyester yarn) or ``"lycra"`` (with elastane). ``"pes@3"``: one of many
        that differ as specimens do; ``"pes@0"`` is ``"pes"``.

    Returns
    -------
    KnitModel

    Raises
    ------
    UserError
        If there is no such preset or specimen.

    Examples
    --------
    >>> import testbench as tb
    >>> first, second = tb.preset("pes"), tb.preset("pes@1")
    >>> first["elasticity"].stiffness_N == second["elasticity"].stiffness_N
    False
    """
    if not isinstance(name, str):
        raise UserError(f"preset: must be one of {', '.join(names())}, got {name!r}")
    kind, at, number = name.partition("@")
    if kind not in names():
        raise UserError(f"no sensor preset called {kind}; there are {', '.join(names())}")
    if at and not (number.isdecimal() and len(number) < 20):
        raise UserError(f"a specimen is a preset, @ and a whole number, such as {kind}@3; got {name}")
    data = json.loads(resources.files(__name__).joinpath(f"{kind}.json").read_text(encoding="utf-8"))
    return specimen(model_from_dict(data, load_catalogue(), source=f"preset {kind}"), int(number or 0))
