"""Where a law may act: a stage of the chain, the signal that it changes, and how."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from testbench.knit.effect import Stage
from testbench.proposing.laws.units import NEWTON, ONE, Unit


@dataclass(frozen=True)
class Place:
    """A place in the chain: a stage, and the signal that a law changes there.

    Attributes
    ----------
    writes : str
        The signal that it changes.
    code : str
        How z changes it: ``{a}`` is the strength.
    unit : Unit
        Of the change.
    channel : str
        The channel that the strength is scaled by: ``force`` or ``conductance``.
    way : str
        How the signal is changed: by an ``amount`` (of ln G, where that is the signal), or otherwise, which only a
        refit tells from that: a force by a ``share``, as exp(a z), so that no z, however large, turns its sign; a
        conductance by a path ``beside`` it, or a resistance ``in series``, in parts of the first value.
    """

    name: str
    words: str
    stage: Stage
    writes: str
    code: str
    latex: str
    unit: Unit
    channel: str
    way: Literal["amount", "share", "beside", "in series"] = "amount"


_FORCE = ("force_N", "F + {a} * x", "F", NEWTON, "force")
_CONDUCTANCE = ("conductance_S", 'shifted(signals["conductance_S"], {a} * x)', r"\ln G", ONE, "conductance")
PLACES = {
    p.name: p
    for p in (
        Place(
            "strain", "the strain that the knit sees", Stage.KINEMATICS, "strain", "e + {a} * x", "e", ONE, "force"
        ),
        Place("force", "the force of the knit", Stage.MECHANICS, *_FORCE),
        Place(
            "force by a share", "the logarithm of the force", Stage.MECHANICS,
            "force_N", "shifted(F, {a} * x)", r"\ln F", ONE, "force", "share",
        ),
        Place(
            "contact force", "the force on the contacts", Stage.PRESSURE,
            "contact_force_N", "P + {a} * x", "P", NEWTON, "conductance",
        ),
        Place("conductance", "the conductance", Stage.ELECTRICAL, *_CONDUCTANCE),
        Place(
            "path beside", "the conductance of a path beside the sensor", Stage.ELECTRICAL,
            "conductance_S", 'beside(signals["conductance_S"], {a} * x)', r"G / G_0", ONE, "conductance", "beside",
        ),
        Place(
            "resistance in series", "a resistance in series with the sensor", Stage.ELECTRICAL,
            "conductance_S", 'in_series(signals["conductance_S"], {a} * x)', r"G_0 / G", ONE, "conductance",
            "in series",
        ),
        Place("force reading", "the reading of the force", Stage.READOUT, *_FORCE),
        Place("conductance reading", "the reading of the conductance", Stage.READOUT, *_CONDUCTANCE),
    )
}  # fmt: skip
