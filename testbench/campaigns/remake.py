"""Make a simulated campaign again from its manifest and compare it byte for byte."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from gcode.support.files import sha256_of
from testbench.campaigns.campaign import campaign_files, simulate_campaign
from testbench.campaigns.plan import plan_of
from testbench.recordings import manifest
from testbench.recordings.versions import changes_since
from testbench.rig.simulation.played import played


@dataclass(frozen=True)
class Remade:
    """What became of a campaign that was made again.

    Attributes
    ----------
    differences : tuple of str
        Sentences that name each file with another byte in it.
    changes : tuple of str
        Software that is not the one it was made with; the manifest's record of it is not compared.
    """

    differences: tuple[str, ...]
    changes: tuple[str, ...]

    def explained(self, folder: Path) -> list[str]:
        """The differences and what may be behind them; empty if not a byte differs."""
        if not self.differences:
            return []
        if self.changes:
            why = f"it was made by other software ({'; '.join(self.changes)}), which is needed to make the same bytes"
        else:
            why = "it was made by the same software: the machine, or the recipe, is not what it says"
        return [*self.differences, f"{folder}: intact, but {why}"]


def made_again(folder: Path, effects: Path | None = None) -> Remade:
    """Make the campaign in `folder` again, elsewhere, and compare; `effects` as for `plan_of`.

    Raises
    ------
    UserError
        If it cannot be made again: it was measured, or its program is gone.
    """
    plan = plan_of(folder, effects)
    motion, _ = played(plan.program, plan.gauge_length_mm)
    changes = tuple(changes_since(manifest.read_manifest(folder)[0].versions))
    with tempfile.TemporaryDirectory() as scratch:
        again = Path(scratch) / "again"
        simulate_campaign(plan, again, motion)
        # By other software the manifest cannot be the same; without it, the files' own bytes tell.
        names = [*campaign_files(folder), *([] if changes else [manifest.NAME])]
        found = tuple(f"{folder / name}: differs when made again" for name in names if not _same(folder, again, name))
    return Remade(found, changes)


def _same(one: Path, other: Path, name: str) -> bool:
    return (other / name).is_file() and sha256_of(one / name) == sha256_of(other / name)
