"""What the parts of a spec share: that they are fixed and know their fields, and numbers with their bounds."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field

from gcode.support.strict import NamedModel

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Duration = Annotated[float, Field(gt=0, le=48 * 3600, allow_inf_nan=False)]
Rest = Annotated[float, Field(ge=0, le=48 * 3600, allow_inf_nan=False)]
Percent = Annotated[float, Field(ge=-100, le=1000, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=1, le=100_000)]
MAX_SAMPLES = 20_000_000  # of a trajectory
LARGEST_SEED = (1 << 53) - 1  # a header's numbers are read as floats, which are exact up to here


class SpecModel(NamedModel):
    """A part of a spec: nothing unknown, and nothing changed once it is made."""

    model_config = ConfigDict(frozen=True, extra="forbid")
