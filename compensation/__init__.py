"""Compensators of drift and hysteresis: ``from compensation import Compensator`` is the scikit-learn regressor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from compensation.regressor import Compensator

__all__ = ["Compensator"]


def __getattr__(name: str) -> Any:
    # scikit-learn is not needed by every command, and takes a second to import.
    if name != "Compensator":
        raise AttributeError(f"module 'compensation' has no attribute {name!r}")
    from compensation.regressor import Compensator

    return Compensator
