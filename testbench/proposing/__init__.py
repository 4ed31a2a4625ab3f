"""When no effect fits: a law found in what the best model leaves, and written down as an effect."""

from typing import TYPE_CHECKING

from gcode.support.lazy import lazy_exports

if TYPE_CHECKING:
    from testbench.proposing.proposal import Proposed as Proposed
    from testbench.proposing.proposal import propose_law as propose_law

__all__, __getattr__, __dir__ = lazy_exports(__name__, {"testbench.proposing.proposal": ["Proposed", "propose_law"]})
