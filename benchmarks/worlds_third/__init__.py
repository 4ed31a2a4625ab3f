"""A third, independent simulator of knitted strain sensors with hidden effects, for final figures alone.

It shares no law with the diagnosis, nor with the two simulators that the diagnosis was developed against: base laws,
effects, motions and the measure of strength are its own. Nobody should tune the diagnosis by what it scores here.
`make_case` makes two recordings of one sensor and says what is hidden in them.
"""

from worlds_third.case import Case, make_case
from worlds_third.effects import MECHANISMS, UNKNOWN_KINDS
from worlds_third.laws import LAW_FAMILIES
from worlds_third.protocols import PROTOCOLS

__all__ = ["LAW_FAMILIES", "MECHANISMS", "PROTOCOLS", "UNKNOWN_KINDS", "Case", "make_case"]
