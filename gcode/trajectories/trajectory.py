"""TrajectorySpec (what is wanted) and Trajectory (position over time), and their files."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import Field

from gcode.motion.statistics import MotionStatistics, motion_statistics
from gcode.support import files
from gcode.support.errors import UserError
from gcode.support.figures import outline, panels
from gcode.support.html import card, strips
from gcode.support.read_only import Unchanging, read_only_array
from gcode.support.strict import check_plain, read_toml, validated
from gcode.trajectories.bounds import Limits
from gcode.trajectories.designed import AnyPiece
from gcode.trajectories.protocol import Piece, Protocol
from gcode.trajectories.quantities import Positive, SpecModel

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

_ROUNDED_S = 1e-4  # of a time in a file, which has four decimals
AMPLE = 5.0  # times the limit: a controller of so much acceleration follows any plan within it


def position_decimals(rate_hz: float) -> int:
    """Decimals of a position: 4 up to 50 Hz; more at higher rates, where rounding would look like acceleration."""
    return 4 if rate_hz <= 50 else 5 if rate_hz <= 150 else 6 if rate_hz <= 500 else 7


class TrajectorySpec(SpecModel):
    """Everything but the seed and the gauge length that decides a trajectory.

    Attributes
    ----------
    name : str
        Lower-case name, for headers and files.
    pieces : tuple of pieces
        The protocol, see `gcode.trajectories.designed`.
    limits : Limits
        Limits of the executed motion.
    rate_hz : float
        Sample rate of the trajectory; each sample becomes a block of the program.
    offset_mm : float
        Pre-tension offset: the machine position of zero strain.
    approach_mm_per_s : float
        Speed of the moves to a piece's first position and back to zero at the end.
    machine_acceleration_mm_per_s2 : float or None
        Acceleration set in the controller, for the feed pre-compensation; None means five times the limit.

    Examples
    --------
    >>> import gcode
    >>> spec = gcode.TrajectorySpec.of(gcode.Hold(duration_s=5) + gcode.Triangle(speed_mm_per_s=1), name="mine")
    >>> gcode.generate(spec, seed=0)
    <Made mine, seed 0: 20.2 s, 0 to 7.5 mm>
    """

    name: str = Field(default="trajectory", pattern=r"^[a-z0-9][a-z0-9._-]{0,40}$")
    pieces: tuple[AnyPiece, ...] = Field(min_length=1)
    limits: Limits = Limits()
    rate_hz: Annotated[float, Field(ge=1, le=1000, allow_inf_nan=False)] = 20.0
    offset_mm: float = Field(default=0.0, allow_inf_nan=False)
    approach_mm_per_s: Positive = 1.0
    machine_acceleration_mm_per_s2: Positive | None = None

    @property
    def controller_acceleration_mm_per_s2(self) -> float:
        """The controller's acceleration, stated or five times the limit."""
        return self.machine_acceleration_mm_per_s2 or AMPLE * self.limits.a_max_mm_per_s2

    @classmethod
    def of(cls, protocol: Protocol | Piece, **settings: Any) -> TrajectorySpec:
        """A spec from a piece or a chain of them: ``TrajectorySpec.of(Hold(...) + Noise(...), name="mine")``."""
        pieces: tuple[Any, ...] = protocol.pieces if isinstance(protocol, Protocol) else (protocol,)
        return cls(pieces=pieces, **settings)


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Unchanging):
    """Position over time, uniformly sampled.

    Attributes
    ----------
    time_s : array (n,)
        Times in steps of 1/rate; two at least.
    position_mm : array (n,)
        Machine position.

    Raises
    ------
    UserError
        If these are no finite numbers, not as many times as positions, or times that are not evenly spaced.

    Examples
    --------
    >>> import gcode
    >>> gcode.Trajectory([0, 0.5, 1], [0, 1, 0])
    <Trajectory 1.0 s at 2 Hz, 0 to 1 mm>
    """

    time_s: np.ndarray
    position_mm: np.ndarray

    def __post_init__(self) -> None:
        time_s, position_mm = (_column(name, getattr(self, name)) for name in ("time_s", "position_mm"))
        if len(time_s) != len(position_mm):
            raise UserError(
                f"Trajectory: as many times as positions are needed, got {len(time_s)} and {len(position_mm)}"
            )
        even_s = np.linspace(time_s[0], time_s[-1], len(time_s))
        if not time_s[-1] > time_s[0] or np.abs(time_s - even_s).max() > _ROUNDED_S:
            raise UserError("Trajectory: time_s must rise in even steps; resample the positions first (numpy.interp)")
        object.__setattr__(self, "time_s", time_s)
        object.__setattr__(self, "position_mm", position_mm)

    @property
    def rate_hz(self) -> float:
        """Sample rate."""
        return float((len(self.time_s) - 1) / (self.time_s[-1] - self.time_s[0]))

    @property
    def duration_s(self) -> float:
        """From the first sample to the last."""
        return float(self.time_s[-1] - self.time_s[0])

    def __repr__(self) -> str:
        low, high = (round(float(end), 9) + 0.0 for end in (self.position_mm.min(), self.position_mm.max()))
        return f"<Trajectory {self.duration_s:.1f} s at {self.rate_hz:g} Hz, {low:.3g} to {high:.3g} mm>"

    def _repr_html_(self) -> str:
        return card(repr(self)[1:-1], self.statistics().lines(), self.curve())

    def curve(self) -> str:
        """The position over time as a small picture for a notebook."""
        time_s, position_mm = outline(self.time_s, self.position_mm, 300)
        return strips(time_s, {"position (mm)": position_mm})

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the position over time on `axes` (default: of a new figure); returns them."""
        (axis,) = panels(axes, 1)
        axis.plot(self.time_s, self.position_mm, linewidth=0.8)
        axis.set_xlabel("time (s)")
        axis.set_ylabel("position (mm)")
        axis.margins(x=0)
        return axis

    def to_frame(self) -> pd.DataFrame:
        """A row a sample: ``time_s``, ``position_mm``."""
        import pandas as pd

        return pd.DataFrame({"time_s": self.time_s, "position_mm": self.position_mm})

    def to_dict(self) -> dict[str, list[float]]:
        """JSON-ready form: the columns of `to_frame`."""
        return {"time_s": self.time_s.tolist(), "position_mm": self.position_mm.tolist()}

    def statistics(self) -> MotionStatistics:
        """Finite-difference statistics at the trajectory's own rate."""
        return motion_statistics(self.position_mm, self.rate_hz)

    def write_csv(self, path: str | FilePath) -> None:
        """Write ``time_s,position_mm`` atomically."""
        columns = np.column_stack((self.time_s, self.position_mm))
        with files.atomic_path(path) as temporary, temporary.open("w", encoding="ascii", newline="\n") as out:
            out.write("time_s,position_mm\n")
            np.savetxt(out, columns, fmt=("%.4f", f"%.{position_decimals(self.rate_hz)}f"), delimiter=",")


def read_csv(path: str | FilePath) -> Trajectory:
    """Read a ``time_s,position_mm`` file; what cannot be read is a `UserError` that names it."""
    check_plain(path, "trajectory")
    try:
        with FilePath(path).open(encoding="utf-8") as stream:
            header = stream.readline(4096).strip().split(",")
            if header[:2] != ["time_s", "position_mm"]:
                raise ValueError(f"the header must begin with time_s,position_mm, got {','.join(header)[:60]}")
            columns = np.loadtxt(stream, delimiter=",", usecols=(0, 1), ndmin=2)
        return Trajectory(columns[:, 0], columns[:, 1])
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: cannot read this trajectory: {getattr(error, 'strerror', error)}") from error
    except ValueError as error:
        raise UserError(f"{path}: not a trajectory: {error}") from error


def sampled(position_mm: np.ndarray, rate_hz: float) -> Trajectory:
    """Positions at a uniform rate, from time zero."""
    return Trajectory(np.arange(len(position_mm)) / rate_hz, position_mm)


def _column(name: str, values: object) -> np.ndarray:
    """Numbers that were given, as an array that nobody changes."""
    try:
        column = read_only_array(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        column = np.zeros(0)
    if column.ndim != 1 or len(column) < 2 or not np.isfinite(column).all():
        raise UserError(f"Trajectory: {name} must be two finite numbers or more in a row, got {str(values)[:60]}")
    return column


def read_spec(path: str | FilePath) -> TrajectorySpec:
    """Read a spec; every fault names the file and the field."""
    return validated(read_toml(path), TrajectorySpec, path, "spec")


def spec_to_toml(spec: TrajectorySpec) -> str:
    """The spec as TOML text; `read_spec` gives an equal spec."""
    data = spec.model_dump(mode="json", exclude_none=True)
    pieces = data.pop("pieces")
    lines = _table(data, "")
    for piece in pieces:
        lines += ["", "[[pieces]]", *_table(piece, "pieces.")]
    return "\n".join(lines) + "\n"


def _table(data: dict[str, Any], prefix: str) -> list[str]:
    plain = {key: value for key, value in data.items() if not isinstance(value, dict)}
    # JSON's numbers, strings and lists of numbers are TOML too.
    lines = [f"{key} = {json.dumps(value)}" for key, value in plain.items()]
    for key, value in data.items():
        if isinstance(value, dict):
            lines += ["", f"[{prefix}{key}]", *_table(value, f"{prefix}{key}.")]
    return lines
