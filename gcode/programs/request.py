"""From the options of the command line to a TrajectorySpec."""

from __future__ import annotations

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
    data = spec.model_dump()
    for option, field in _LIMITS.items():
        if getattr(args, option) is not None:
            data["limits"][field] = getattr(args, option)
    if args.machine_acceleration is not None:
        data["machine_acceleration_mm_per_s2"] = args.machine_acceleration
    if args.duration_s is not None:
        noises = [piece for piece in data["pieces"] if piece["kind"] == "noise"]
        if len(noises) != 1:
            raise UserError(f"--duration-s needs a spec with one noise piece, this one has {len(noises)}")
        noises[0]["duration_s"] = args.duration_s
    return TrajectorySpec.model_validate(data)
