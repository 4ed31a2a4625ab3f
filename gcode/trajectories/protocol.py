"""What every piece of a protocol has in common, and pieces in a row."""

from __future__ import annotations

from typing import Any

from pydantic import Field, SerializeAsAny, model_validator

from gcode.motion.path import Frame, Path
from gcode.trajectories.quantities import Percent, SpecModel


class Piece(SpecModel):
    """One piece of a protocol. Subclasses say where to be and when, from the position they are entered at."""

    @property
    def strokes(self) -> int:
        """Straight moves and rests of its path, at most; of a curve, which has a duration, one."""
        return 1

    def path(self, start_mm: float, frame: Frame) -> Path:
        """The piece's path; its first position may differ from `start_mm`, then an approach is put before it."""
        raise NotImplementedError

    def __add__(self, other: Piece | Protocol) -> Protocol:
        """Chain two pieces, or a piece and a protocol."""
        return Protocol(pieces=(self,)) + other

    def __radd__(self, nothing: int) -> Protocol:
        """The piece after nothing: where ``sum`` begins."""
        return nothing + Protocol(pieces=(self,))


class Protocol(SpecModel):
    """Pieces in a row."""

    pieces: tuple[SerializeAsAny[Piece], ...] = Field(min_length=1)

    def __add__(self, other: Piece | Protocol) -> Protocol:
        more = other.pieces if isinstance(other, Protocol) else (other,)
        return Protocol(pieces=(*self.pieces, *more))

    def __radd__(self, nothing: int) -> Protocol:
        return self if nothing == 0 else NotImplemented


class RangedPiece(Piece):
    """A piece that moves between two strains."""

    low_percent: Percent = 0.0
    high_percent: Percent = 30.0

    @model_validator(mode="after")
    def _ordered(self) -> Any:
        if not self.low_percent < self.high_percent:
            raise ValueError(
                f"low_percent must be below `high_percent`, got {self.low_percent:g} and {self.high_percent:g}"
            )
        return self
