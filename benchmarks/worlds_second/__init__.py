"""A second, independent simulator of knitted strain sensors with hidden effects, to judge the diagnosis by.

It shares no law with the diagnosis or with the first hidden worlds: every base law and every effect is its own,
drawn with the seed. `make_case` makes two recordings of one sensor and says what is hidden in them.
"""

from worlds_second.case import Case, make_case
from worlds_second.effects import MECHANISMS, UNKNOWN_KINDS
from worlds_second.laws import LAW_FAMILIES
from worlds_second.protocols import PROTOCOLS

__all__ = ["LAW_FAMILIES", "MECHANISMS", "PROTOCOLS", "UNKNOWN_KINDS", "Case", "make_case"]
