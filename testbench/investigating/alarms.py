"""After an alarm: the strain at which the force passed its limit bounds every motion from then on."""

from __future__ import annotations

from pathlib import Path

from gcode.support.errors import UserError
from testbench.investigating.state import Settings
from testbench.recordings.channels import DISPLACEMENT, FORCE
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import read_manifest

SAFE = 0.9  # share of that strain that is used again


def after_alarm(folder: Path, settings: Settings) -> Settings:
    """What may be planned once the recording in `folder` has ended with an alarm.

    Raises
    ------
    UserError
        If no motion can be planned within what is left: the load cell was at fault, or the limit is too low.
    """
    reached = _strain_at_end_percent(folder)
    if reached is None:
        return settings
    allowed = min(SAFE * reached, settings.limits.strain_max_percent)
    try:
        return Settings(**settings.model_dump() | {"strain_allowed_percent": allowed})
    except UserError:
        raise UserError(
            f"{folder}: the force passed its limit at a strain of {reached:.3g} %, and no motion can be planned "
            f"within {allowed:.3g} %; if the load cell was at fault, move {folder} away and go on with `resume`, "
            "else begin a new investigation with another `max_force_N`"
        ) from None


def set_aside(folder: Path) -> Path:
    """Give a campaign that an alarm ended a name of its own, ``run-2-alarm-1``; returns it.

    Raises
    ------
    UserError
        If it cannot be moved.
    """
    number = 1
    while (place := folder.with_name(f"{folder.name}-alarm-{number}")).exists():
        number += 1
    try:
        return folder.rename(place)
    except OSError as error:
        raise UserError(f"cannot move {folder} to {place}: {error.strerror}; move it yourself") from error


def _strain_at_end_percent(folder: Path) -> float | None:
    """Strain of the last sample, at which the force was too large; None where it was not a motion that made it so."""
    campaign, _ = read_manifest(folder)
    if int(campaign.counts.get("samples", 0)) < 2:
        return None  # it was too large from the start
    recording = read_recording(folder)
    if not recording.has(FORCE):
        return None  # the device sent none, so that nothing could be watched
    return 100 * abs(float(recording[DISPLACEMENT][-1])) / recording.gauge_length_mm
