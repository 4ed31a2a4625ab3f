"""Make a simulated campaign again from its manifest and compare it byte for byte."""

from __future__ import annotations

import tempfile
from pathlib import Path

from testbench import manifest
from testbench.campaign import campaign_files, plan_of, simulate_campaign
from testbench.rig.motion import played


def differences(folder: Path) -> list[str]:
    """What differs when the campaign in `folder` is made again; empty if not a byte does.

    Raises
    ------
    UserError
        If it cannot be made again: it was measured, or its program is gone.
    """
    plan = plan_of(folder)
    motion, _ = played(plan.program, plan.gauge_length_mm)
    with tempfile.TemporaryDirectory() as scratch:
        again = Path(scratch) / "again"
        simulate_campaign(plan, again, motion)
        names = [*campaign_files(folder), manifest.NAME]
        found = [f"{folder / name}: differs when made again" for name in names if not _same(folder, again, name)]
    return found + (_other_versions(folder) if found else [])


def _same(one: Path, other: Path, name: str) -> bool:
    return (other / name).is_file() and (one / name).read_bytes() == (other / name).read_bytes()


def _other_versions(folder: Path) -> list[str]:
    then, now = manifest.read_manifest(folder)[0].versions, manifest.software_versions()
    other = [f"made with {name} {then.get(name)}, now {now[name]}" for name in now if then.get(name) != now[name]]
    return other or ["made with the same versions: knitbench's own code, or the machine, is not the same"]
