"""What the parts of a spec share: that they are fixed and know their fields, and numbers with their bounds."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from gcode.support.errors import UserError, first_problem
from gcode.support.kinds import only_by_name

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Duration = Annotated[float, Field(gt=0, le=48 * 3600, allow_inf_nan=False)]
Rest = Annotated[float, Field(ge=0, le=48 * 3600, allow_inf_nan=False)]
Percent = Annotated[float, Field(ge=-100, le=1000, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=1, le=100_000)]
MAX_SAMPLES = 20_000_000  # of a trajectory
LARGEST_SEED = (1 << 53) - 1  # a header's numbers are read as floats, which are exact up to here


class SpecModel(BaseModel):
    """A part of a spec: nothing unknown, and nothing changed once it is made."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def __init__(self, *unnamed: Any, **fields: Any) -> None:
        """Raise `UserError` where a field is unknown, unnamed or missing, or has a value that it cannot have."""
        only_by_name(type(self), "fields", unnamed)
        try:
            super().__init__(**fields)
        except ValidationError as error:
            raise UserError(f"{type(self).__name__}: {first_problem(error)}") from None

    # As pydantic marks its own: what is validated as a part of something else is not made by a call of `__init__`, so
    # that the error says where in the whole it is.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]
