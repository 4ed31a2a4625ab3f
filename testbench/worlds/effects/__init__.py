"""Hidden effects, one file a stage, each in several forms: importing the files registers them."""

from testbench.worlds.effects import electrical, grip, mechanics, readout, unknown
from testbench.worlds.effects.registry import FORMS, UNKNOWN

__all__ = ["FORMS", "UNKNOWN", "electrical", "grip", "mechanics", "readout", "unknown"]
