"""Which physical effect is missing: models compared by their evidence."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from testbench.diagnosis.diagnosis import Diagnosis, diagnose

__all__ = ["Diagnosis", "diagnose"]


def __getattr__(name: str) -> Any:
    # Loaded on first use: the command line must not pay for it on --help.
    if name in __all__:
        import importlib

        return getattr(importlib.import_module("testbench.diagnosis.diagnosis"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
