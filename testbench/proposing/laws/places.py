"""Where a law may act: a stage of the chain, the signal that it changes, and how."""

from __future__ import annotations

from dataclasses import dataclass

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
    is_share : bool
        Whether it changes a force by a share, as exp(a z): then no z, however large, turns the sign of the force.
    """

    name: str
    words: str
    stage: Stage
    writes: str
    code: str
    latex: str
    unit: Unit
    channel: str
    is_share: bool = False


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
            "force_N", "shifted(F, {a} * x)", r"\ln F", ONE, "force", is_share=True,
        ),
        Place(
            "contact force", "the force on the contacts", Stage.PRESSURE,
            "contact_force_N", "P + {a} * x", "P", NEWTON, "conductance",
        ),
        Place("conductance", "the conductance", Stage.ELECTRICAL, *_CONDUCTANCE),
        Place("force reading", "the reading of the force", Stage.READOUT, *_FORCE),
        Place("conductance reading", "the reading of the conductance", Stage.READOUT, *_CONDUCTANCE),
    )
}  # fmt: skip
