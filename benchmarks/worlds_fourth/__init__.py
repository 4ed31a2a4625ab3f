"""A fourth, independent simulator of knitted strain sensors with hidden effects, for final figures alone.

Written by somebody who had read neither the model of the diagnosis nor the other simulators: eight elastic curves,
six frictions, six laws of conduction, and 25 mechanisms with three laws or four each. Nobody should tune the
diagnosis by what it scores here. `make_case` makes two recordings of one sensor and says what is hidden in them.
"""

from worlds_fourth.case import PROTOCOLS, Case, make_case
from worlds_fourth.effects import MECHANISMS, UNKNOWN_KINDS
from worlds_fourth.laws import LAW_FAMILIES

__all__ = ["LAW_FAMILIES", "MECHANISMS", "PROTOCOLS", "UNKNOWN_KINDS", "Case", "make_case"]
