"""Compensators of drift and hysteresis: ``from compensation import Compensator`` is the scikit-learn regressor.

Rooms, from the ground up: `memories`, `engines` and `series`; `model`; `training`; `paper`, `search`, `estimators`,
`export` and `scoring`; `commands`. What is named here is imported when it is first asked for.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from compensation.estimators.regressor import Compensator
    from compensation.model.files import load
    from compensation.model.prediction import predicted
    from compensation.model.streaming import CompensatorStream

__all__ = ["Compensator", "CompensatorStream", "load", "predicted"]

# scikit-learn is not needed by every command, and takes a second to import.
_HOMES = {
    "Compensator": "compensation.estimators.regressor",
    "CompensatorStream": "compensation.model.streaming",
    "load": "compensation.model.files",
    "predicted": "compensation.model.prediction",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'compensation' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
