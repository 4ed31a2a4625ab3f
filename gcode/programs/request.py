"""A spec with some of it changed."""

from __future__ import annotations

from collections.abc import Mapping

from gcode.support.errors import UserError, first_problem
from gcode.trajectories.bounds import Limits
from gcode.trajectories.trajectory import TrajectorySpec


def changed(
    spec: TrajectorySpec,
    limits: Mapping[str, float],
    duration_s: float | None = None,
    machine_acceleration_mm_per_s2: float | None = None,
) -> TrajectorySpec:
    """`spec` with other limits and, where they are given, another duration of its noise and another controller.

    Raises
    ------
    UserError
        If there is no such limit, a duration is given and the spec has not exactly one noise piece, or a value cannot
        be.
    """
    if unknown := [name for name in limits if name not in Limits.model_fields]:
        raise UserError(f"there is no limit {unknown[0]}; limits are {', '.join(Limits.model_fields)}")
    data = spec.model_dump()
    data["limits"] |= limits
    if machine_acceleration_mm_per_s2 is not None:
        data["machine_acceleration_mm_per_s2"] = machine_acceleration_mm_per_s2
    if duration_s is not None:
        noises = [piece for piece in data["pieces"] if piece["kind"] == "noise"]
        if len(noises) != 1:
            raise UserError(f"the duration needs a spec with one noise piece, this one has {len(noises)}")
        noises[0]["duration_s"] = duration_s
    try:
        return TrajectorySpec.model_validate(data)
    except ValueError as error:
        raise UserError(first_problem(error)) from None
