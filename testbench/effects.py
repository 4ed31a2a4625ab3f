"""Every effect of the catalogue by its class name: ``testbench.effects.StressRelaxation(fraction=0.2)``.

Examples
--------
>>> from testbench import effects
>>> effects.StressRelaxation(fraction=0.2).fraction
0.2
>>> "MullinsSoftening" in dir(effects)
True
"""

from __future__ import annotations

from difflib import get_close_matches
from typing import cast

from gcode.support.lazy import lazy_exports
from testbench.knit.catalogue import LAWS
from testbench.knit.effect import Effect
from testbench.knit.effect_names import class_name

_homes = {f"testbench.knit.{file}": [class_name(name) for name in names.split()] for file, names in LAWS.items()}
__all__, _get, __dir__ = lazy_exports(__name__, _homes)


def __getattr__(name: str) -> type[Effect]:
    try:
        return cast(type[Effect], _get(name))
    except AttributeError as error:
        near = get_close_matches(class_name(name), __all__, 1)
        meant = f"; did you mean {near[0]}?" if near else ""
        raise AttributeError(f"{error}{meant}; `testbench effects` lists them all") from None
