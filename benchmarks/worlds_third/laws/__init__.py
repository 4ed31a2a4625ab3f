"""Base laws: what every sensor has. One file a family, several members each, drawn at random.

A family is a mapping of names to `Law`. Strains are over the stroke (0 to 1), forces over the force at its end.
"""

from worlds_third.laws.choice import Chosen, Law, choose_laws
from worlds_third.laws.families import FAMILIES, LAW_FAMILIES

__all__ = ["FAMILIES", "LAW_FAMILIES", "Chosen", "Law", "choose_laws"]
