"""What laws are made of: coordinates, and operators on them, each with its code, its formula and its words.

A law's changing part z is a *coordinate* (what the knit does or has gone through) followed by *operators* (a memory,
a bend, a factor). Every piece is one line of Python that acts on whole signals; the same line is tried in the search,
fitted in the model and written into the effect file, so that what was judged is what comes out.

Names in the code: ``e`` strain, ``F`` force, ``P`` contact force, ``ln_g`` ln of the conductance since the start,
``t`` time, ``T`` temperature since the start, ``x`` what came out of the line before, ``self.KEY`` a parameter;
``{span}`` and ``{size}`` stand for the largest strain of the recording and the usual size of `x`, written as numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

from testbench.proposing.laws.units import ONE, Unit

STRAIN, FORCE, PRESSING, LN_G = ("strain",), ("force_N",), ("contact_force_N",), ("conductance_S",)
TIME, WARM = ("time_s",), ("temperature_C",)
DIRECTION = (r"d = \pm 1 \text{ while stretching / releasing}",)  # what d stands for in formulas


@dataclass(frozen=True)
class Slot:
    """A parameter that a piece needs.

    Attributes
    ----------
    key : str
        Its name in the effect; it ends in its unit where that is not 1.
    kind : str
        Where its values lie: ``time`` constant; ``delay``; ``skew``, a share of the time; ``level``, ``size`` or
        ``rate`` of the input `x` (in its unit, or that per second); ``strain``; ``path``; ``swing`` of the strain;
        ``frequency``; ``number`` between `low` and `high`; ``angle``.
    jumps : bool
        Whether z jumps as it changes, so that no derivative tells how well the data know it.
    """

    key: str
    symbol: str
    doc: str
    kind: str = "time"
    low: float = 0.0
    high: float = 0.0
    jumps: bool = False


@dataclass(frozen=True)
class Coordinate:
    """What a law may depend on: a signal computed from those in the chain.

    Attributes
    ----------
    code : str
        One expression.
    reads : tuple of str
        Signals of the chain that it needs.
    """

    name: str
    code: str
    latex: str
    words: str
    unit: Unit = ONE
    reads: tuple[str, ...] = STRAIN
    slots: tuple[Slot, ...] = ()
    definitions: tuple[str, ...] = ()
    signed: bool = True


@dataclass(frozen=True)
class Operator:
    """One step of a term, from its input `x` to its output.

    `latex` and `words` hold ``{x}`` where the input stands.
    """

    name: str
    code: str
    latex: str
    words: str
    kind: str  # "memory", "bend" or "factor"
    slots: tuple[Slot, ...] = ()
    definitions: tuple[str, ...] = ()
    reads: tuple[str, ...] = ()
    unit: Unit | None = None  # of the output; None: that of the input, times `times`
    times: Unit = ONE
    squares: bool = False
    only_positive: bool = False


Piece = TypeVar("Piece", Coordinate, Operator)


def named(*pieces: Piece) -> dict[str, Piece]:
    """Pieces by their names."""
    return {one.name: one for one in pieces}
