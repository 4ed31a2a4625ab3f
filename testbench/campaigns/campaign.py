"""A campaign folder: recording, program and a manifest from which it can be made again, byte for byte."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from gcode.support.errors import UserError
from gcode.support.files import copy_file, make_folder
from testbench.campaigns.clearing import replaced
from testbench.campaigns.plan import EFFECTS, PROGRAM, Plan, past_names
from testbench.recordings import manifest
from testbench.recordings.files import write_recording_csv
from testbench.recordings.manifest import CSV, Campaign, read_manifest, write_manifest
from testbench.recordings.recording import Recording
from testbench.recordings.stored import EVENTS
from testbench.recordings.versions import software_versions
from testbench.rig.acquisition.recorder import DISK_STATES, Recorder, Report, Status, counts
from testbench.rig.acquisition.sink import BAD, COMPENSATED, Sink, synced
from testbench.rig.connection.parts import Part, in_memory
from testbench.rig.protocol.items import Item
from testbench.rig.protocol.stream import Intake
from testbench.rig.simulation.at_once import at_once
from testbench.rig.simulation.simulated import Motion

COARSE_STEP = 0.01  # of a reading, which one code of the divider's ADC changes; by 0.02 % on the paper's bench


def matches(folder: Path, plan: Plan) -> bool:
    """Whether `folder` already holds the finished campaign of `plan`, every byte of it."""
    if not (folder / manifest.NAME).is_file():
        return False
    campaign, _ = read_manifest(folder)
    same = campaign.origin == "simulated" and campaign.gauge_length_mm == plan.gauge_length_mm
    same = same and campaign.recipe == json.loads(json.dumps(plan.recipe()))
    whole = campaign.status == "complete" and campaign.counts.get("samples", 0) > 1
    return same and whole and not manifest.problems(folder)


def simulate_campaign(
    plan: Plan, folder: Path, motion: Motion, report: Report = lambda status: None, overwrite: bool = False
) -> Status:
    """Run `plan` on the simulated rig at once and write its campaign folder, whole or not at all.

    Parameters
    ----------
    plan : Plan
    folder : Path
        Must not exist yet, or be empty; see `testbench.campaigns.clearing.replaced`.
    motion : Motion
        What the controller makes of the plan's program.
    report : callable
        Called with the progress.
    overwrite : bool
        Replace another simulated campaign in `folder`, once this one is whole.
    """
    with replaced(folder, overwrite) as draft:
        plan.copy_sources(draft)
        # Intake: a rig that delivers at once has no host time to hold its clock against.
        recorder = _recorder(draft, plan, motion, report, Intake(host_clock=False))
        status = filled(draft, "simulated", plan.recipe(), recorder, at_once(plan.rig(motion)))
        if status.state in DISK_STATES:
            raise UserError(f"{folder}: nothing was kept, {status.message}; make room, or choose another place")
        _check_accepted(folder, status)
    return replace(status, message=_coarse(plan, status))


def simulate_live(
    plan: Plan,
    folder: Path,
    motion: Motion,
    report: Report = lambda status: None,
    pace: Callable[[Iterable[bytes]], Iterable[Part]] = in_memory,
    stopped: Callable[[], bool] = lambda: False,
) -> Status:
    """Run `plan` as `simulate_campaign` does, but in its place, to be read while it grows.

    Parameters
    ----------
    pace : callable
        Makes a link of the rig's lines, for instance `testbench.rig.connection.parts.real_time`.
    stopped : callable
        Whether to end early.
    """
    make_folder(folder)
    plan.copy_sources(folder)
    begun = Campaign(plan.gauge_length_mm, "simulated", manifest.IN_PROGRESS, plan.recipe(), {}, software_versions())
    write_manifest(folder, begun, [CSV, EVENTS, *plan.source_names()])
    recorder = _recorder(folder, plan, motion, report, Intake(host_clock=pace is not in_memory))
    status = filled(folder, "simulated", plan.recipe(), recorder, pace(plan.rig(motion).lines()), stopped)
    _check_accepted(folder, status)
    return replace(status, message=status.message or _coarse(plan, status))


def _coarse(plan: Plan, status: Status) -> str:
    """What to say of a divider that does not suit the sensor; empty where it does."""
    divider, ohm = plan.instruments.divider, status.resistance_ohm
    if not ohm:
        return ""
    share = divider.reference_ohm / ohm
    step = (1 + share) ** 2 / share * divider.full_scale_V / 2**15 / divider.supply_V
    if step < COARSE_STEP:
        return ""
    steps = f"the divider reads the resistance in steps of {100 * step:.0f} %"
    return f"{steps}: give it a reference nearer to {ohm:.2g} ohm"


def _check_accepted(folder: Path, status: Status) -> None:
    """Refuse to call a run complete that nobody can read as a recording."""
    if status.state != "complete" or status.samples > 1:
        return
    if not status.samples:
        raise UserError(
            f"{folder}: none of the simulated rig's {status.rejected} lines was accepted, so that there is no "
            "recording: the model, or an instrument, makes values that no device sends; check their parameters"
        )
    raise UserError(
        f"{folder}: the simulated rig took one sample in {status.duration_s:.4g} s, and a recording needs two; raise "
        "its sampling rate, or play a longer program"
    )


def _recorder(folder: Path, plan: Plan, motion: Motion, report: Report, intake: Intake) -> Recorder:
    return Recorder(intake, Sink(folder), plan.gauge_length_mm, duration_s=motion.duration_s, report=report)


def filled(
    folder: Path,
    origin: str,
    recipe: dict[str, Any],
    recorder: Recorder,
    link: Iterable[Part],
    stopped: Callable[[], bool] = lambda: False,
    first: Iterable[Item] = (),
) -> Status:
    """Let a recorder take what `link` delivers, close its files in `folder`, and write the manifest over them.

    A disk that does not even take the manifest leaves the campaign unfinished, as a killed recorder does: its files
    are as readable as those, and `testbench record --resume` takes it up.

    Parameters
    ----------
    first : iterable of Item
        What is written before the first of the link.
    """
    sink, intake = recorder.sink, recorder.intake
    try:
        sink.write(first)
        with synced(sink):
            status = recorder.run(link, stopped)
    finally:
        whole = sink.close()
    status.sync_failures = sink.sync_failures
    counted = counts(intake) | {"samples": intake.accepted - status.unwritten}
    counted |= {"unwritten": status.unwritten} if status.unwritten else {}
    counted |= {"sync_failures": status.sync_failures} if status.sync_failures else {}
    campaign = Campaign(recorder.gauge_length_mm, origin, status.state, recipe, counted, software_versions())
    problem = "a file could not be closed with a whole line"
    for _ in recorder.trials() if whole else ():
        try:
            write_manifest(folder, campaign, campaign_files(folder))
            return status
        except (OSError, UserError) as error:
            problem = str(error)
    state = status.state if status.state in ("alarm", *DISK_STATES) else "disk error"
    unfinished = f"the manifest could not be written, so the campaign stays unfinished ({problem})"
    return replace(status, state=state, message="; ".join(filter(None, (status.message, unfinished))))


def write_derived(
    folder: Path, recording: Recording, how: str, details: dict[str, Any], program: Path, overwrite: bool = False
) -> None:
    """Write a recording that was made from another one; its recipe is the other's plus `details` under `how`."""
    recipe = {**recording.metadata.get("recipe", {}), how: {**details, "source": Path(recording.source).name}}
    counted = {"samples": len(recording)}
    made = Campaign(recording.gauge_length_mm, how, "complete", recipe, counted, software_versions())
    with replaced(folder, overwrite, how) as draft:
        write_recording_csv(draft / CSV, recording)
        copy_file(program, draft / PROGRAM)
        write_manifest(draft, made, campaign_files(draft))


def campaign_files(folder: Path) -> list[str]:
    """The files of a campaign, recording first; the manifest itself is not among them."""
    count = len(list(folder.glob("before-*.tap")))
    names = [CSV, PROGRAM, EVENTS, BAD, COMPENSATED, *past_names(count), EFFECTS]
    return [name for name in names if (folder / name).exists()]
