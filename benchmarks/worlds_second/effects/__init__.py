"""Hidden effects: forms of the known mechanisms, and kinds that no catalogue has."""

from worlds_second.effects import (
    electrical,
    heat,
    kinematics,
    mechanics,
    pressure,
    readout,
    strangers_fabric,
    strangers_rig,
)
from worlds_second.effects.registry import FOREIGN, KNOWN, Form

MECHANISMS: list[str] = list(KNOWN)
UNKNOWN_KINDS: list[str] = list(FOREIGN)

__all__ = [
    "FOREIGN",
    "KNOWN",
    "MECHANISMS",
    "UNKNOWN_KINDS",
    "Form",
    "electrical",
    "heat",
    "kinematics",
    "mechanics",
    "pressure",
    "readout",
    "strangers_fabric",
    "strangers_rig",
]
