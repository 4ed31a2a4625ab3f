"""When no effect fits: a law found in what the best model leaves, and written down as an effect."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from testbench.proposing.proposal import Proposed, propose_law

__all__ = ["Proposed", "propose_law"]


def __getattr__(name: str) -> Any:
    # Loaded on first use: the command line must not pay for it on --help.
    if name in __all__:
        import importlib

        return getattr(importlib.import_module("testbench.proposing.proposal"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
