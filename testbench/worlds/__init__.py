"""Test data with a hidden effect: sensors of which somebody else wrote the physics.

The worlds share no code with `testbench.knit`, `testbench.fitting` or `testbench.diagnosis`, and their authors do
not look at how the diagnosis works: they are its adversary. Laws and forms differ from the catalogue's on purpose.
"""

from testbench.worlds.case import CATALOGUE, NOISES, OUTSIDE, Case, make_case

__all__ = ["CATALOGUE", "NOISES", "OUTSIDE", "Case", "make_case"]
