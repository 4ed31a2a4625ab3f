"""Which physical effect is missing: models compared by their evidence."""

from typing import TYPE_CHECKING

from gcode.support.lazy import lazy_exports

if TYPE_CHECKING:
    from testbench.diagnosis.diagnosis import Diagnosis as Diagnosis
    from testbench.diagnosis.diagnosis import diagnose as diagnose

__all__, __getattr__, __dir__ = lazy_exports(__name__, {"testbench.diagnosis.diagnosis": ["Diagnosis", "diagnose"]})
