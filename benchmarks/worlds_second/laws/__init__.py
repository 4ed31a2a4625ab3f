"""Base laws of the drawn sensors.

All work on relative quantities: strain over its maximum, force over its full scale.
"""

from worlds_second.laws import contact, drift, elasticity, force_loops, resistance_loops
from worlds_second.laws.registry import FAMILIES, Member

LAW_FAMILIES: dict[str, list[str]] = {family: list(members) for family, members in FAMILIES.items()}

__all__ = [
    "FAMILIES",
    "LAW_FAMILIES",
    "Member",
    "contact",
    "drift",
    "elasticity",
    "force_loops",
    "resistance_loops",
]
