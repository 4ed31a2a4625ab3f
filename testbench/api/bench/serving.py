"""`serve_rig`: the simulated rig behind a serial port, for a recorder that knows no other."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from numpy.random import default_rng

from gcode.programs.make import Made
from gcode.support.errors import UserError
from gcode.support.kinds import number, path_of
from testbench.api.arguments import AnyModel, own_file
from testbench.api.bench.running import planned
from testbench.rig.connection.parts import paced
from testbench.rig.simulation.faults import faulty
from testbench.rig.simulation.played import DEFAULT_REST_S
from testbench.rig.simulation.pty_port import PtyPort, serve


def serve_rig(
    model: AnyModel,
    program: Made | str | Path,
    *,
    seed: int = 1,
    gauge_length_mm: float | None = None,
    after: Iterable[str | Path] = (),
    rest_s: float = DEFAULT_REST_S,
    effects: str | Path | None = None,
    link: str | Path | None = None,
    speed: float = 1.0,
    faults: float = 0.0,
    announce: Callable[[str], None] = lambda port: None,
) -> int:
    """Put the simulated rig behind a pseudo-terminal, and play a program once somebody listens to it.

    Parameters
    ----------
    model, program, seed, gauge_length_mm, after, rest_s, effects
        As for `testbench.run`.
    link : path, optional
        Symbolic link to the port, for a name that is known beforehand.
    speed : float
        Times faster than real.
    faults : float
        Share of the lines that are damaged on their way, 0 to 1.
    announce : callable
        Called with the name of the port, which `testbench.record` is to listen to.

    Returns
    -------
    int
        How many lines were sent while nobody listened.

    Raises
    ------
    UserError
        If the program cannot be played, the model makes values that are not finite, or the link cannot be made.

    Examples
    --------
    >>> import gcode
    >>> import testbench as tb
    >>> try:
    ...     tb.serve_rig(tb.preset("pes"), gcode.generate("paper-1", seed=1, duration_s=20), faults=2)
    ... except tb.UserError as error:
    ...     print(error)
    faults: must be a share from 0 to 1, got 2
    """
    if not 0 < number("speed", speed) < float("inf"):
        raise UserError(f"speed: must be a positive number, got {speed:g}")
    if not 0 <= number("faults", faults) <= 1:
        raise UserError(f"faults: must be a share from 0 to 1, got {faults}")
    ready = planned(model, program, seed, gauge_length_mm, None, after, rest_s, own_file(effects))
    with ready as (plan, motion):
        lines = plan.wire_lines(motion)
    port = PtyPort(None if link is None else path_of(link, "link to the port"))
    try:
        announce(port.name)
        unheard = serve(port, faulty(paced(lines, speed), faults, default_rng(seed)))
        if port.has_reader():
            port.wait_for_reader(wanted=False)
    finally:
        port.close()
    return unheard
