"""Base laws: what every sensor has. One file a family, several members each, drawn one after the other."""

from worlds_fourth.laws.conduction import CONDUCTIONS
from worlds_fourth.laws.contact_loops import CONTACT_LOOPS, ContactLoops, draw_contact_loops
from worlds_fourth.laws.courses import COURSES, Conduction, draw_conduction
from worlds_fourth.laws.drift import DRIFTS, PLACES, drift_of
from worlds_fourth.laws.elasticity import CURVES, Elasticity, draw_elasticity
from worlds_fourth.laws.friction import FRICTIONS, Friction, draw_friction

LAW_FAMILIES = {
    "elasticity": list(CURVES),
    "friction": list(FRICTIONS),
    "conduction": list(CONDUCTIONS),
    "course": list(COURSES),
    "contact_loops": list(CONTACT_LOOPS),
    "drift": list(DRIFTS),
    "drift_place": list(PLACES),
}

__all__ = [
    "CONTACT_LOOPS",
    "COURSES",
    "DRIFTS",
    "LAW_FAMILIES",
    "PLACES",
    "Conduction",
    "ContactLoops",
    "Elasticity",
    "Friction",
    "draw_conduction",
    "draw_contact_loops",
    "draw_elasticity",
    "draw_friction",
    "drift_of",
]
