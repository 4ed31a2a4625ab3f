"""A campaign folder: recording, program and a manifest from which it can be made again, byte for byte."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from gcode.support.errors import UserError
from gcode.support.files import make_folder, sha256_of
from testbench import manifest
from testbench.knit.model import KnitModel
from testbench.manifest import Campaign, read_manifest, write_manifest
from testbench.recording import Recording
from testbench.recording_files import write_recording_csv
from testbench.rig.instruments import Instruments
from testbench.rig.motion import played
from testbench.rig.past import DEFAULT_REST_S, past_displacement
from testbench.rig.recorder import Part, Recorder, Status, counts, in_memory
from testbench.rig.simulated import GRID_HZ, Motion, SimulatedRig
from testbench.rig.sink import CSV, EVENTS, Sink
from testbench.rig.stream import Intake
from testbench.versions import software_versions

PROGRAM = "program.tap"


@dataclass(frozen=True)
class Plan:
    """Everything that a simulated campaign depends on.

    Attributes
    ----------
    program : Path
        Mach4 program.
    model : KnitModel
    gauge_length_mm : float
    seed : int
    sensor : str
        Name of the preset, or of the file that the model came from.
    instruments : Instruments
    past : tuple of Path
        Programs that the same sensor went through before, in order; empty: a sensor never stretched before.
    rest_s : float
        Rest after each of them.
    """

    program: Path
    model: KnitModel
    gauge_length_mm: float
    seed: int
    sensor: str = ""
    instruments: Instruments = field(default_factory=Instruments)
    past: tuple[Path, ...] = ()
    rest_s: float = DEFAULT_REST_S

    def recipe(self) -> dict[str, Any]:
        """As written into the manifest."""
        recipe = {
            "sensor": self.sensor,
            "model": self.model.to_dict(),
            "seed": self.seed,
            "program": PROGRAM,
            "program_sha256": sha256_of(self.program),
            "grid_hz": GRID_HZ,
            "instruments": self.instruments.model_dump(mode="json"),
        }
        if self.past:
            recipe |= {"past_sha256": [sha256_of(path) for path in self.past], "rest_s": self.rest_s}
        return recipe

    def rig(self, motion: Motion) -> SimulatedRig:
        """The rig that will play this plan along `motion`."""
        earlier = [_played(path, sha256_of(path), self.gauge_length_mm) for path in self.past]
        past_mm = past_displacement(earlier, self.rest_s)
        return SimulatedRig(self.model, motion, self.gauge_length_mm, self.seed, self.instruments, past_mm)

    def copy_programs(self, folder: Path) -> None:
        """Put everything that the campaign is to be made from into its folder."""
        shutil.copyfile(self.program, folder / PROGRAM)
        for name, path in zip(past_names(len(self.past)), self.past, strict=True):
            shutil.copyfile(path, folder / name)


@lru_cache(maxsize=8)
def _played(path: Path, sha256: str, gauge_length_mm: float) -> Motion:
    return played(path, gauge_length_mm)[0]


def past_names(count: int) -> list[str]:
    """File names of the earlier programs in a campaign folder, first played first."""
    return [f"before-{number + 1}.tap" for number in range(count)]


def plan_of(folder: Path) -> Plan:
    """The plan of a simulated campaign, from its manifest and program.

    Raises
    ------
    UserError
        If the campaign was measured, not simulated, or its program is no longer the one it was made with.
    """
    from testbench.knit.catalogue import load_catalogue, model_from_dict

    campaign, _ = read_manifest(folder)
    if campaign.origin != "simulated":
        raise UserError(f"{folder}: this campaign was {campaign.origin}, only a simulated one can be made again")
    recipe, program = campaign.recipe, folder / PROGRAM
    digests = recipe.get("past_sha256", [])
    past = tuple(folder / name for name in past_names(len(digests)))
    for path, digest in zip((program, *past), (recipe.get("program_sha256"), *digests), strict=True):
        if not path.is_file() or sha256_of(path) != digest:
            raise UserError(f"{path}: missing or not the program that the manifest names")
    model = model_from_dict(recipe.get("model"), load_catalogue(), str(folder / manifest.NAME))
    instruments = Instruments.model_validate(recipe["instruments"])
    rest_s = float(recipe.get("rest_s", DEFAULT_REST_S))
    seed, sensor = int(recipe["seed"]), recipe["sensor"]
    return Plan(program, model, campaign.gauge_length_mm, seed, sensor, instruments, past, rest_s)


def programs_before(sources: Iterable[str | Path], model: KnitModel, gauge_length_mm: float) -> tuple[Path, ...]:
    """The programs that a sensor went through, from what ``--after`` names: programs, or campaigns of this sensor.

    Raises
    ------
    UserError
        If a campaign is of another sensor, gauge length or origin: its state cannot be carried on.
    """
    programs: list[Path] = []
    for source in map(Path, sources):
        if not source.is_dir():
            if not source.is_file():
                raise UserError(f"{source}: no such campaign or program; name what the sensor went through before")
            programs.append(source)
            continue
        earlier = plan_of(source)
        if earlier.model != model:
            raise UserError(f"{source}: a campaign of another sensor, {earlier.sensor}; its state cannot go on")
        if earlier.gauge_length_mm != gauge_length_mm:
            raise UserError(
                f"{source}: its gauge length is {earlier.gauge_length_mm:g} mm, this one's {gauge_length_mm:g} mm; "
                "give --gauge-length-mm"
            )
        programs += [*earlier.past, earlier.program]
    return tuple(programs)


def matches(folder: Path, plan: Plan) -> bool:
    """Whether `folder` already holds the finished campaign of `plan`, every byte of it."""
    if not (folder / manifest.NAME).is_file():
        return False
    campaign, _ = read_manifest(folder)
    same = campaign.origin == "simulated" and campaign.gauge_length_mm == plan.gauge_length_mm
    same = same and campaign.recipe == json.loads(json.dumps(plan.recipe()))
    return same and campaign.status == "complete" and not manifest.problems(folder)


def simulate_campaign(
    plan: Plan, folder: Path, motion: Motion, report: Callable[[Status], None] = lambda status: None
) -> Status:
    """Run `plan` on the simulated rig at once and write its campaign folder, whole or not at all.

    Parameters
    ----------
    plan : Plan
    folder : Path
        Must not exist yet, or be empty (see `vacant`).
    motion : Motion
        What the controller makes of the plan's program.
    report : callable
        Called with the progress.
    """
    make_folder(folder.parent)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}.") as scratch:
        draft = make_folder(Path(scratch) / "campaign")
        plan.copy_programs(draft)
        status = _fill(draft, plan, motion, report, in_memory)
        draft.replace(folder)
    return status


def simulate_live(
    plan: Plan,
    folder: Path,
    motion: Motion,
    report: Callable[[Status], None] = lambda status: None,
    pace: Callable[[Iterable[bytes]], Iterable[Part]] = in_memory,
    stopped: Callable[[], bool] = lambda: False,
) -> Status:
    """Run `plan` as `simulate_campaign` does, but in its place, to be read while it grows.

    Parameters
    ----------
    pace : callable
        Makes a link of the rig's lines, for instance `testbench.rig.links.real_time`.
    stopped : callable
        Whether to end early.
    """
    make_folder(folder)
    plan.copy_programs(folder)
    begun = Campaign(plan.gauge_length_mm, "simulated", manifest.IN_PROGRESS, plan.recipe(), {}, software_versions())
    write_manifest(folder, begun, [CSV, PROGRAM, EVENTS, *past_names(len(plan.past))])
    return _fill(folder, plan, motion, report, pace, stopped)


def _fill(
    folder: Path,
    plan: Plan,
    motion: Motion,
    report: Callable[[Status], None],
    pace: Callable[[Iterable[bytes]], Iterable[Part]],
    stopped: Callable[[], bool] = lambda: False,
) -> Status:
    intake, sink = Intake(), Sink(folder)
    try:
        recorder = Recorder(intake, sink, plan.gauge_length_mm, duration_s=motion.duration_s, report=report)
        status = recorder.run(pace(plan.rig(motion).lines()), stopped)
    finally:
        sink.close()
    finish(folder, plan.gauge_length_mm, "simulated", status.state, plan.recipe(), intake)
    return status


def finish(
    folder: Path, gauge_length_mm: float, origin: str, state: str, recipe: dict[str, Any], intake: Intake
) -> None:
    """Write the manifest over the files in `folder`."""
    campaign = Campaign(gauge_length_mm, origin, state, recipe, counts(intake), software_versions())
    write_manifest(folder, campaign, campaign_files(folder))


def write_derived(folder: Path, recording: Recording, how: str, details: dict[str, Any], program: Path) -> None:
    """Write a recording that was made from another one; its recipe is the other's plus `details` under `how`."""
    make_folder(folder)
    write_recording_csv(folder / CSV, recording)
    shutil.copyfile(program, folder / PROGRAM)
    recipe = {**recording.metadata.get("recipe", {}), how: {**details, "source": Path(recording.source).name}}
    made = Campaign(
        recording.gauge_length_mm, how, "complete", recipe, {"samples": len(recording)}, software_versions()
    )
    write_manifest(folder, made, campaign_files(folder))


def campaign_files(folder: Path) -> list[str]:
    """The files of a campaign, recording first; the manifest itself is not among them."""
    count = len(list(folder.glob("before-*.tap")))
    names = [CSV, PROGRAM, EVENTS, "recording.bad", *past_names(count)]
    return [name for name in names if (folder / name).exists()]


def vacant(folder: Path, overwrite: bool = False) -> None:
    """Make sure that `folder` may be written; remove a simulated campaign if `overwrite`.

    Raises
    ------
    UserError
        If something else is there. A measured campaign is never removed.
    """
    if not folder.exists() or (folder.is_dir() and not any(folder.iterdir())):
        return
    if not folder.is_dir() or not (folder / manifest.NAME).is_file():
        raise UserError(f"{folder}: exists and is not a campaign; choose another place with -o")
    campaign, _ = read_manifest(folder)
    if campaign.origin == "recorded":
        raise UserError(f"{folder}: holds a recorded campaign, which is never overwritten; choose another with -o")
    if not overwrite:
        raise UserError(f"{folder}: holds another campaign; choose another place with -o, or add --overwrite")
    shutil.rmtree(folder)
