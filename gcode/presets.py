"""Named trajectories: the three of the paper and its fast one."""

from __future__ import annotations

from gcode.protocol import Noise
from gcode.support.errors import UserError
from gcode.trajectory import Limits, TrajectorySpec

_PAPER = {
    "paper-1": Noise(cells_per_s=0.316, octaves=2, persistence=0.15, peak=0.7036, min_speed_mm_per_s=0.218),
    "paper-2": Noise(cells_per_s=0.320, octaves=2, persistence=0.15, peak=0.678, min_speed_mm_per_s=0.261),
    "paper-3": Noise(cells_per_s=0.357, octaves=1, persistence=0.15, peak=0.808, min_speed_mm_per_s=0.241),
}
_FAST = Noise(cells_per_s=0.257, octaves=3, persistence=0.5, peak=0.572, min_speed_mm_per_s=0.707, high_percent=50.0)

PRESETS: dict[str, TrajectorySpec] = {
    **{
        name: TrajectorySpec(name=name, pieces=(noise,), limits=Limits(v_max_mm_per_s=5.0, a_max_mm_per_s2=20.0))
        for name, noise in _PAPER.items()
    },
    "fast": TrajectorySpec(
        name="fast", pieces=(_FAST,), limits=Limits(v_max_mm_per_s=15.0, a_max_mm_per_s2=70.0), approach_mm_per_s=2.0
    ),
}


def preset(name: str) -> TrajectorySpec:
    """The named spec.

    Raises
    ------
    UserError
        If there is none of this name.
    """
    if name not in PRESETS:
        raise UserError(f"preset must be one of {', '.join(PRESETS)}; got {name!r}")
    return PRESETS[name]
