"""What makes sense as a law: where a coordinate may act, which operators may follow it, and what a law costs."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from testbench.knit.effect import FloatArray, Stage
from testbench.proposing.laws.law import MOST_PARAMETERS, Term
from testbench.proposing.laws.law_coordinates import COORDINATES, KINETICS
from testbench.proposing.laws.law_parts import Coordinate, Operator
from testbench.proposing.laws.places import Place

PRICE_OF_PIECE, PRICE_OF_PARAMETER = 2.0, 2.0  # nats: so many more laws have one piece, or one number, more
INSTRUMENT = {"conductance rate", "force", "conductance", "time", "temperature", "heating power", "force rate"}
OF_STRAIN = {"strain", "largest strain", "below the largest strain", "past the last top", "path", "turns", "time",
             "from a share of the last top",
             "direction", "strain rate", "speed", "acceleration", "time since reversal", "temperature"}  # fmt: skip
OF_CONTACTS = {"contact force", "strain", "largest strain", "path", "time", "temperature", "time since reversal"}
SIGNALS = {"strain", "force", "contact force", "conductance"}
SIGNAL_ONLY = {  # memories that make sense of some coordinates alone
    "slip": SIGNALS,
    "relaxing slip": SIGNALS,
    "ring": SIGNALS,
    "late": {"force", "conductance", "strain"},
    "echo": {"force", "conductance"},
    "clock": {"force", "conductance"},
    "slow": {"force", "conductance", "strain"},
    "dead band": {"force", "conductance", "strain"},
    "stick": {"strain", "force"},
}
NO_MEMORY = {"time", "direction", "turns", "path", "work"}  # what only grows has all of its past already
ONLY_GROWS = NO_MEMORY - {"direction"} | {"largest strain"}
EVENTS = {"bell", "bell at", "switch", "wave"}  # over what only grows they happen once, and predict nothing
ALLOWED = {Stage.READOUT: INSTRUMENT, Stage.KINEMATICS: OF_STRAIN, Stage.PRESSURE: OF_CONTACTS}


def coordinates_at(place: Place, readable: Collection[str]) -> list[Coordinate]:
    """What a law at a place may depend on, of the signals that it can read."""
    allowed = ALLOWED.get(place.stage)
    kinds = [c for c in COORDINATES.values() if allowed is None or c.name in allowed]
    if place.stage in (Stage.KINEMATICS, Stage.MECHANICS, Stage.ELECTRICAL):
        kinds += KINETICS.values()
    return [c for c in kinds if set(c.reads) <= set(readable)]


def fits(term: Term, one: Operator, at: int, x: FloatArray) -> bool:
    """Whether an operator makes sense there, and leaves few enough numbers with names of their own.

    Parameters
    ----------
    at : int
        Operators of the term before it.
    x : ndarray
        What it would act on.
    """
    keys = [slot.key for slot in (*term.slots, *one.slots)]
    if len(keys) + 1 > MOST_PARAMETERS or len(set(keys)) < len(keys) or not np.ptp(x):
        return False
    if one.name == "size" and not np.min(x) < 0 < np.max(x):
        return False
    return _follows(term, one, at)


def price_of(term: Term) -> float:
    """What a law costs for being one of so many, in nats."""
    return PRICE_OF_PIECE * len(term.operators) + PRICE_OF_PARAMETER * len(term.slots)


def _follows(term: Term, one: Operator, at: int) -> bool:
    """One memory, two bends, two factors at the end; what is positive for logarithms."""
    kinds = [o.kind for o in term.operators]
    name = term.coordinate.name
    if one.kind == "memory":
        if "memory" in kinds or name in NO_MEMORY or name in KINETICS:
            return False
        if one.name in SIGNAL_ONLY:
            return at == 0 and name in SIGNAL_ONLY[one.name]
        return True
    if name in ONLY_GROWS and one.name in EVENTS and (name, one.name) != ("time", "wave"):
        return False
    if {one.name, *(o.name for o in term.operators)} >= {"square", "power"}:
        return False
    if one.kind == "factor":
        return kinds.count("factor") < 2 and at == len(kinds)
    if one.name == "log":
        return name in KINETICS and at == 0
    if one.only_positive and term.coordinate.signed and "size" not in [o.name for o in term.operators[:at]]:
        return False
    return kinds.count("bend") < 2
