"""Which physical effect is missing: models compared by their evidence."""

from typing import TYPE_CHECKING

from gcode.support.lazy import lazy_exports

if TYPE_CHECKING:
    from testbench.diagnosis.diagnosis import diagnose as diagnose
    from testbench.diagnosis.result import Diagnosis as Diagnosis

__all__, __getattr__, __dir__ = lazy_exports(
    __name__, {"testbench.diagnosis.diagnosis": ["diagnose"], "testbench.diagnosis.result": ["Diagnosis"]}
)
