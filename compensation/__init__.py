"""Compensators of drift and hysteresis: ``from compensation import Compensator`` is the scikit-learn regressor.

Rooms, from the ground up: `memories`, `engines` and `series`; `model`; `training`; `paper`, `search`, `estimators`,
`export` and `scoring`; `commands`. What is named here is imported when it is first asked for.
"""

from typing import TYPE_CHECKING

from gcode.support.lazy import lazy_exports

if TYPE_CHECKING:  # for type checkers and editors; in a running program `_HOMES` says where a name is imported from
    from compensation.estimators.regressor import Compensator as Compensator
    from compensation.export.export_c import c_header as c_header
    from compensation.export.export_onnx import write_onnx as write_onnx
    from compensation.model.files import load as load
    from compensation.model.prediction import predicted as predicted
    from compensation.model.streaming import CompensatorStream as CompensatorStream

_HOMES = {
    "compensation.estimators.regressor": ["Compensator"],
    "compensation.export.export_c": ["c_header"],
    "compensation.export.export_onnx": ["write_onnx"],
    "compensation.model.files": ["load"],
    "compensation.model.prediction": ["predicted"],
    "compensation.model.streaming": ["CompensatorStream"],
}
__all__, __getattr__, __dir__ = lazy_exports(__name__, _HOMES)
