"""What every piece of a protocol has in common."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator

from gcode.path import Frame, Path

if TYPE_CHECKING:
    from gcode.protocol import Protocol

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Duration = Annotated[float, Field(gt=0, le=48 * 3600, allow_inf_nan=False)]
Rest = Annotated[float, Field(ge=0, le=48 * 3600, allow_inf_nan=False)]
Percent = Annotated[float, Field(ge=-100, le=1000, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=1, le=100_000)]


class Piece(BaseModel):
    """One piece of a protocol. Subclasses say where to be and when, from the position they are entered at."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def path(self, start_mm: float, frame: Frame) -> Path:
        """The piece's path; its first position may differ from `start_mm`, then an approach is put before it."""
        raise NotImplementedError

    def __add__(self, other: Piece | Protocol) -> Protocol:
        """Chain two pieces, or a piece and a protocol."""
        from gcode.protocol import Protocol

        return Protocol(pieces=(self,)) + other


class RangedPiece(Piece):
    """A piece that moves between two strains."""

    low_percent: Percent = 0.0
    high_percent: Percent = 30.0

    @model_validator(mode="after")
    def _ordered(self) -> Any:
        if not self.low_percent < self.high_percent:
            raise ValueError(
                f"low_percent must be below high_percent, got {self.low_percent:g} and {self.high_percent:g}"
            )
        return self
