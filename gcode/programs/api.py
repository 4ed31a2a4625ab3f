"""The public functions of `gcode`; the command line is a thin user of the same."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import get_args

from gcode.mach4.check import CheckResult
from gcode.mach4.controller import Machine
from gcode.mach4.controller import play as played
from gcode.mach4.program import Program
from gcode.mach4.reader import load_program, read_program, read_text
from gcode.mach4.writer import FeedMode
from gcode.programs.made_again import check_file
from gcode.programs.make import Made, make
from gcode.support.errors import UserError, first_problem
from gcode.support.kinds import flag, instance, number
from gcode.trajectories.bounds import Limits
from gcode.trajectories.presets import preset
from gcode.trajectories.protocol import Piece, Protocol
from gcode.trajectories.trajectory import Trajectory, TrajectorySpec, read_spec


def generate(
    spec: str | Path | TrajectorySpec | Protocol | Piece,
    seed: int,
    gauge_length_mm: float = 25.0,
    *,
    duration_s: float | None = None,
    feed_mode: FeedMode = "G94",
    machine_acceleration_mm_per_s2: float | None = None,
    **limits: float,
) -> Made:
    """Plan a trajectory, write its Mach4 program and check it.

    Parameters
    ----------
    spec : str, path, TrajectorySpec, Protocol or Piece
        A preset (``"paper-1"``, ``"paper-2"``, ``"paper-3"``, ``"fast"``), a TOML file, or pieces:
        ``gcode.Hold(duration_s=5) + gcode.Noise(duration_s=600)``.
    seed : int
        From 0 to 2^53 - 1; other seeds give independent trajectories of the same statistics.
    gauge_length_mm : float
        Length of the sample between the grips.
    duration_s : float, optional
        Of the one noise piece of the spec.
    feed_mode : {"G94", "G93"}
        Feed per minute, or inverse time.
    machine_acceleration_mm_per_s2 : float, optional
        The controller's; default: the spec's, or five times the limit.
    **limits
        Fields of `gcode.Limits`: ``v_max_mm_per_s``, ``a_max_mm_per_s2``, ``x_max_mm``, ...

    Returns
    -------
    Made
        ``.trajectory``, ``.program`` (the text), ``.statistics`` of the motion as executed, ``.write(folder)``.

    Raises
    ------
    UserError
        If the request cannot be planned within its limits.

    Examples
    --------
    >>> import gcode
    >>> made = gcode.generate("paper-1", seed=3, duration_s=60)
    >>> made
    <Made paper-1, seed 3: 66.0 s, 0 to 6.3 mm>
    >>> triangles = gcode.Triangle(high_percent=20, speed_mm_per_s=1, cycles=3) + gcode.Hold(duration_s=10)
    >>> round(gcode.generate(triangles, seed=0).statistics.x_max_mm, 1)
    5.0
    """
    if feed_mode not in get_args(FeedMode):
        raise UserError(f"feed_mode must be {' or '.join(get_args(FeedMode))}, got {feed_mode!r}")
    wanted = _changed(_spec(spec), limits, duration_s, machine_acceleration_mm_per_s2)
    return make(wanted, seed, gauge_length_mm, feed_mode)


def read(path: str | Path) -> Program:
    """Read a Mach4 program, or a plain RS274/NGC program that moves one axis.

    Parameters
    ----------
    path : str or path

    Returns
    -------
    Program

    Raises
    ------
    UserError
        If it cannot be read; the message names the first line that is refused.

    Examples
    --------
    >>> import tempfile
    >>> import gcode
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = gcode.generate("paper-1", seed=3, duration_s=60).write(folder)
    ...     gcode.read(f"{folder}/program.tap").header["seed"]
    '3'
    """
    if isinstance(path, str) and "\n" in path:
        raise UserError("read: takes the path of a program, got its text; check and play take the text itself")
    return load_program(path)


def check(
    program: str | Path | Program | Made,
    limits: Limits | None = None,
    *,
    rate_hz: float = 20.0,
    machine: Machine | None = None,
    rapid_mm_per_s: float | None = None,
    longest_dwell_s: float | None = None,
    as_foreign: bool = False,
) -> CheckResult:
    """Check a program against limits, as programmed and as executed.

    Parameters
    ----------
    program : str, path, Program or Made
        The text of a program, its file, a program that was read, or one that was generated.
    limits : Limits, optional
        Of speed, acceleration, jerk and travel; default: `gcode.Limits()`.
    rate_hz : float
        Rate of the finite differences.
    machine : Machine, optional
        The controller; default: five times the limit of acceleration.
    rapid_mm_per_s : float, optional
        Speed of G0 moves; default: unknown, so that they are refused.
    longest_dwell_s : float, optional
        Default: 120 s; a program of ours that was made again from its recipe may dwell as long as it likes.
    as_foreign : bool
        Do not hold a program of ours against the recipe in its header; of a text or a file only.

    Returns
    -------
    CheckResult
        ``.ok``, ``.problems`` (line and reason), ``.statistics`` of the motion as executed.

    Raises
    ------
    UserError
        If there is no such file, or `program` is none of these. What is wrong with a program is no error here, but
        a problem of the result.

    Examples
    --------
    >>> import gcode
    >>> made = gcode.generate("paper-1", seed=3, duration_s=60)
    >>> gcode.check(made.program, gcode.Limits(v_max_mm_per_s=1.0)).ok
    False
    """
    allowed = Limits() if limits is None else instance("limits", limits, Limits)
    as_foreign = flag("as_foreign", as_foreign)
    others = {"rapid_mm_per_s": rapid_mm_per_s, "longest_dwell_s": longest_dwell_s}
    if isinstance(program, Program):
        from gcode.mach4.check import check_program

        if as_foreign:
            raise UserError("as_foreign: is of a text or a file, whose header is then not heeded; leave it out here")
        return check_program(program, allowed, rate_hz, machine, **others)
    return check_file(text_of(program)[0], allowed, rate_hz, machine, **others, as_foreign=as_foreign)[0]


def play(program: str | Path | Program | Made, rate_hz: float = 20.0, machine: Machine | None = None) -> Trajectory:
    """What a look-ahead controller makes of a program.

    Parameters
    ----------
    program : str, path, Program or Made
        The text of a program, its file, a program that was read, or one that was generated.
    rate_hz : float
        Sample rate of the result.
    machine : Machine, optional
        The controller; default: as the program's header says.

    Returns
    -------
    Trajectory
        ``.time_s`` and ``.position_mm``, each shape (n,).

    Raises
    ------
    UserError
        If a line cannot be read: what would be left out could be any motion.

    Examples
    --------
    >>> import gcode
    >>> gcode.play(gcode.generate("paper-1", seed=3, duration_s=60)).position_mm[0].item()
    0.0
    """
    return played(program if isinstance(program, Program) else read_program(*text_of(program)), rate_hz, machine)


def text_of(program: str | Path | Made) -> tuple[str, str]:
    """The text of a program, and what messages call it; a string without a line end is the path of its file."""
    if isinstance(program, Made):
        return program.program, "program"
    if isinstance(program, str) and "\n" in program:
        return program, "program"
    if not isinstance(program, str | Path):
        kind = type(program).__name__
        raise UserError(f"program: must be its text, its path, a Program or what `generate` made, got {kind}")
    return read_text(program), str(program)


def _spec(spec: str | Path | TrajectorySpec | Protocol | Piece) -> TrajectorySpec:
    if isinstance(spec, TrajectorySpec):
        return spec
    if isinstance(spec, Protocol | Piece):
        return TrajectorySpec.of(spec)
    if not isinstance(spec, str | Path):
        kind = type(spec).__name__
        raise UserError(
            f"spec: must be a preset's name, a TOML file, a spec or a piece (join pieces with +), got {kind}"
        )
    return read_spec(spec) if isinstance(spec, Path) or spec.endswith(".toml") else preset(spec)


def _changed(
    spec: TrajectorySpec,
    limits: Mapping[str, float],
    duration_s: float | None,
    machine_acceleration_mm_per_s2: float | None,
) -> TrajectorySpec:
    """`spec` with other limits and, where they are given, another duration of its noise and another controller."""
    if unknown := [name for name in limits if name not in Limits.model_fields]:
        raise UserError(f"there is no limit {unknown[0]}; limits are {', '.join(Limits.model_fields)}")
    data = spec.model_dump()
    data["limits"] = Limits(**data["limits"] | limits)
    if machine_acceleration_mm_per_s2 is not None:
        data["machine_acceleration_mm_per_s2"] = number(
            "machine_acceleration_mm_per_s2", machine_acceleration_mm_per_s2
        )
    if duration_s is not None:
        noises = [piece for piece in data["pieces"] if piece["kind"] == "noise"]
        if len(noises) != 1:
            raise UserError(f"the duration needs a spec with one noise piece, this one has {len(noises)}")
        noises[0]["duration_s"] = number("duration_s", duration_s)
    try:
        return TrajectorySpec.model_validate(data)
    except ValueError as error:
        raise UserError(first_problem(error)) from None
