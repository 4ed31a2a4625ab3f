"""Base laws: what every sensor has. One file a family, several members each, drawn at random.

A family is a mapping of names to `Law`. Strains are over the stroke (0 to 1), forces over the force at its end.
"""

from worlds_third.laws.conductance import CONDUCTANCE
from worlds_third.laws.drift import DRIFT
from worlds_third.laws.elasticity import ELASTICITY
from worlds_third.laws.hysteresis import HYSTERESIS
from worlds_third.laws.loops import LOOPS
from worlds_third.laws.places import DRIVES, PLACES

FAMILIES = {
    "elasticity": ELASTICITY,
    "hysteresis": HYSTERESIS,
    "drive": DRIVES,
    "conductance": CONDUCTANCE,
    "loops": LOOPS,
    "drift": DRIFT,
    "drift_place": PLACES,
}
LAW_FAMILIES = {family: list(members) for family, members in FAMILIES.items()}
