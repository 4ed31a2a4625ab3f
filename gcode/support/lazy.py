"""Public names that are imported when they are first asked for: ``import testbench`` must cost nothing."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Any


def lazy_exports(
    package: str, homes: Mapping[str, Iterable[str]]
) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """``__all__``, ``__getattr__`` and ``__dir__`` of a package whose names live in slow modules (PEP 562).

    Parameters
    ----------
    package : str
        ``__name__`` of the package.
    homes : mapping of str to iterable of str
        Module -> the names that are taken from it. The names of the module `package` itself are its submodules.

    Examples
    --------
    >>> names, get, _ = lazy_exports("gcode", {"gcode.trajectories.presets": ["preset"]})
    >>> names
    ['preset']
    >>> get("preset")("paper-1").name
    'paper-1'
    """
    home_of = {name: module for module, names in homes.items() for name in names}

    def get(name: str) -> Any:
        if name not in home_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        home = home_of[name]
        inside = home == package
        found = importlib.import_module(f"{home}.{name}") if inside else getattr(importlib.import_module(home), name)
        setattr(sys.modules[package], name, found)
        return found

    return list(home_of), get, lambda: sorted(home_of)
