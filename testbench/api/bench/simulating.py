"""`simulate`: what the rig would record of a sensor that a model describes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from gcode.programs.api import generate
from gcode.programs.make import Made
from gcode.support.kinds import number
from testbench.api.arguments import AnyModel, Effects
from testbench.api.bench.running import planned
from testbench.campaigns.campaign import simulate_campaign
from testbench.knit.catalogue import baseline
from testbench.knit.effect import Effect
from testbench.recordings.files import read_recording
from testbench.recordings.instruments import Instruments
from testbench.recordings.recording import Recording
from testbench.rig.simulation.played import DEFAULT_REST_S

EXAMPLE_S = 180.0


def simulate(
    model: AnyModel,
    program: Made | str | Path,
    *,
    seed: int = 1,
    gauge_length_mm: float | None = None,
    instruments: Instruments | None = None,
    after: Iterable[str | Path] = (),
    rest_s: float = DEFAULT_REST_S,
    effects: Effects = None,
) -> Recording:
    """Play a program on the simulated rig, whose sensor is `model`, and read what it records.

    The same as `testbench.run` followed by `testbench.read`: jittered sampling times, noise and resolution of the
    instruments included. No files are kept.

    Parameters
    ----------
    model, program, seed, gauge_length_mm, instruments, after, rest_s
        As for `testbench.run`; the presets ``"pes"`` and ``"lycra"`` behave like published sensors.
    effects : path, Catalogue or effect classes, optional
        The user's own effects that a model file uses.

    Returns
    -------
    Recording
        ``displacement_mm``, ``force_N`` and ``resistance_ohm``, as far as the model makes them.

    Raises
    ------
    UserError
        If the program cannot be played, or the model makes values that are not finite.

    Examples
    --------
    >>> import gcode
    >>> import testbench as tb
    >>> tb.simulate("pes", gcode.generate("paper-1", seed=3, duration_s=60)).has("resistance_ohm")
    True
    """
    ready = planned(model, program, seed, gauge_length_mm, instruments, after, rest_s, effects)
    with ready as (plan, motion), TemporaryDirectory(prefix="knitbench-") as temporary:
        simulate_campaign(plan, Path(temporary) / "campaign", motion)
        recording = read_recording(Path(temporary) / "campaign")
    name = f"{program.spec.name}-{program.seed}" if isinstance(program, Made) else plan.program.name
    return _named(recording, f"simulated {name}, seed of noise {seed}")


def example(*effects: Effect, seed: int = 1, duration_s: float = EXAMPLE_S) -> Recording:
    """Three minutes of a simulated sensor to try things on: the baseline with `effects` put in.

    Parameters
    ----------
    *effects : Effect
        What a diagnosis should find to be missing.
    seed : int
        Of motion, noise and sampling times: another seed is another recording of the same sensor.
    duration_s : float
        Of the motion, 1 or more; the way back to zero comes after it.

    Returns
    -------
    Recording

    Raises
    ------
    UserError
        If the seed or the duration is none that a motion can have.

    Examples
    --------
    >>> import testbench as tb
    >>> tb.example(seed=2).gauge_length_mm
    25.0
    """
    model = baseline()
    for effect in effects:
        model = model + effect
    program = generate("paper-1", seed=seed, duration_s=number("duration_s", duration_s, 1.0))
    return _named(simulate(model, program, seed=seed), f"example-{seed}")


def _named(recording: Recording, name: str) -> Recording:
    """A recording under a name that one of another sensor does not have."""
    return replace(recording, source=f"{name} ({recording.digest})")
