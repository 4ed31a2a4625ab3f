"""Named trajectories: the three of the paper and its fast one."""

from __future__ import annotations

from collections.abc import Mapping

from gcode.support.errors import UserError
from gcode.support.read_only import read_only
from gcode.trajectories.natural import NAMES, Noise, Target
from gcode.trajectories.trajectory import Limits, TrajectorySpec


def _spec(
    name: str, noise: Noise, target: tuple[float, float, float, float], sprint_mm_per_s: float, a_max_mm_per_s2: float
) -> TrajectorySpec:
    wanted = Target(**dict(zip(NAMES, target, strict=True)))
    noise = noise.model_copy(update={"target": wanted, "sprint_mm_per_s": sprint_mm_per_s})
    limits = Limits(v_max_mm_per_s=round(1.05 * sprint_mm_per_s, 2), a_max_mm_per_s2=a_max_mm_per_s2)
    return TrajectorySpec(name=name, pieces=(noise,), limits=limits, approach_mm_per_s=wanted.v_mean_mm_per_s)


_SLOW = Noise(octaves=2, persistence=0.12, cells_per_s=0.316, peak=0.7, min_speed_mm_per_s=0.2, pace_spread=0.1)
_FAST = Noise(
    octaves=2,
    persistence=0.2,
    cells_per_s=0.627,
    peak=0.7,
    min_speed_mm_per_s=0.39,
    pace_spread=0.87,
    high_percent=50.0,
)

# Targets and fastest strokes are those of the paper's Table 1 and of its fast set; each seed is tuned to them. The
# shapes to start from were found by `gcode fit` at a gauge length of 25 mm.
PRESETS: Mapping[str, TrajectorySpec] = read_only(
    {
        "paper-1": _spec("paper-1", _SLOW, (0.943, 0.593, 1.397, 1.303), 4.142, 20.0),
        "paper-2": _spec("paper-2", _SLOW, (0.979, 0.617, 1.497, 1.343), 4.93, 20.0),
        "paper-3": _spec("paper-3", _SLOW, (1.03, 0.644, 1.546, 1.414), 4.039, 20.0),
        "fast": _spec("fast", _FAST, (2.87, 2.06, 9.27, 7.87), 14.0, 70.0),
    }
)


def preset(name: str) -> TrajectorySpec:
    """A trajectory of the paper by its name: what `generate` plans from.

    Parameters
    ----------
    name : str
        One of `PRESETS`.

    Returns
    -------
    TrajectorySpec

    Raises
    ------
    UserError
        If there is none of this name.

    Examples
    --------
    >>> import gcode
    >>> gcode.preset("paper-1").limits.a_max_mm_per_s2
    20.0
    """
    if name not in list(PRESETS):  # a list has no hash
        raise UserError(f"preset must be one of {', '.join(PRESETS)}; got {name!r}")
    return PRESETS[name]
