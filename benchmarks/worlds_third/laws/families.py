"""All families of base laws."""

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
