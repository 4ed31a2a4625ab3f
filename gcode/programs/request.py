"""A spec by name or from a file, with some of it changed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gcode.support.errors import UserError
from gcode.trajectories.presets import preset
from gcode.trajectories.toml_spec import read_spec
from gcode.trajectories.trajectory import TrajectorySpec

_LIMITS = {
    "v_max": "v_max_mm_per_s",
    "a_max": "a_max_mm_per_s2",
    "j_max": "j_max_mm_per_s3",
    "x_min": "x_min_mm",
    "x_max": "x_max_mm",
}


def spec_from(args: Any) -> TrajectorySpec:
    """The spec of a preset or a file with the command line's changes applied."""
    spec = preset(args.preset) if args.preset else read_spec(args.spec)
    limits = {field: getattr(args, option) for option, field in _LIMITS.items()}
    return changed(spec, limits, args.duration_s, args.machine_acceleration)


def changed(
    spec: TrajectorySpec,
    limits: Mapping[str, float | None],
    duration_s: float | None = None,
    machine_acceleration_mm_per_s2: float | None = None,
) -> TrajectorySpec:
    """`spec` with those limits, the duration of its noise and the controller's acceleration that are not None.

    Raises
    ------
    UserError
        If a duration is given and the spec has not exactly one noise piece.
    """
    data = spec.model_dump()
    data["limits"] |= {field: value for field, value in limits.items() if value is not None}
    if machine_acceleration_mm_per_s2 is not None:
        data["machine_acceleration_mm_per_s2"] = machine_acceleration_mm_per_s2
    if duration_s is not None:
        noises = [piece for piece in data["pieces"] if piece["kind"] == "noise"]
        if len(noises) != 1:
            raise UserError(f"the duration needs a spec with one noise piece, this one has {len(noises)}")
        noises[0]["duration_s"] = duration_s
    return TrajectorySpec.model_validate(data)
