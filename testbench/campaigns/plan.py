"""What a simulated campaign is made from: everything that its bytes depend on, kept in its own folder."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from gcode.support.errors import UserError
from gcode.support.files import copy_file, sha256_of
from testbench.knit.model import KnitModel
from testbench.recordings import manifest
from testbench.recordings.files import check_beside
from testbench.recordings.instruments import Instruments
from testbench.recordings.manifest import read_manifest
from testbench.rig.acquisition.ending import EndOfMotion
from testbench.rig.simulation.played import DEFAULT_REST_S, past_displacement, played
from testbench.rig.simulation.simulated import SIMULATED_HZ, Motion, SimulatedRig
from testbench.trust import named_effects

PROGRAM, EFFECTS = "program.tap", "effects.py"
# The rig on a port stands still after its motion for so long, and for as long as a recorder waits, within reason.
HOLD_S, MOST_HOLD_S = 3.0, 60.0
Rests = float | tuple[float, ...]


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
        Of noise and sampling times; each recording of one sensor has its own of them.
    sensor : str
        Name of the preset, or of the file that the model came from.
    instruments : Instruments
    past : tuple of Path
        Programs that the same sensor went through before, in order; empty: a sensor never stretched before.
    rest_s : float or tuple of float
        Rest after each of them: one for all, or each its own.
    effects : Path, optional
        Python file with effects of the user's own that the model uses.
    """

    program: Path
    model: KnitModel
    gauge_length_mm: float
    seed: int
    sensor: str = ""
    instruments: Instruments = field(default_factory=Instruments)
    past: tuple[Path, ...] = ()
    rest_s: Rests = DEFAULT_REST_S
    effects: Path | None = None

    def recipe(self) -> dict[str, Any]:
        """What the manifest keeps of the plan, from which the campaign can be made again."""
        recipe = {
            "sensor": self.sensor,
            "model": self.model.to_dict(),
            "seed": self.seed,
            "program": PROGRAM,
            "program_sha256": sha256_of(self.program),
            "grid_hz": SIMULATED_HZ,
            "instruments": self.instruments.model_dump(mode="json"),
        }
        if self.past:
            recipe |= {"past_sha256": [sha256_of(path) for path in self.past], "rest_s": self.rest_s}
        if self.effects:
            recipe["effects_sha256"] = sha256_of(self.effects)
        return recipe

    def rig(self, motion: Motion) -> SimulatedRig:
        """The rig that will play this plan along `motion`."""
        earlier = [motion_of(path, self.gauge_length_mm) for path in self.past]
        past_mm = past_displacement(earlier, self.rest_s, float(motion.displacement_mm[0]))
        gauge, tools, before = self.gauge_length_mm, self.instruments, len(self.past)
        return SimulatedRig(self.model, motion, gauge, self.seed, tools, past_mm, before)

    def wire_lines(self, motion: Motion) -> list[bytes]:
        """All lines that the rig sends to a port while it plays this plan along `motion`, and then stands still."""
        hold_s = HOLD_S + min(EndOfMotion.of(motion).patience_s, MOST_HOLD_S)
        return list(self.rig(motion.held(hold_s)).lines())

    def copy_sources(self, folder: Path) -> None:
        """Put all files that the campaign is to be made from into its folder."""
        sources = [self.program, *self.past, *([self.effects] if self.effects else [])]
        for name, path in zip(self.source_names(), sources, strict=True):
            copy_file(path, folder / name)

    def source_names(self) -> list[str]:
        """Names of the sources' copies in the campaign folder."""
        return [PROGRAM, *past_names(len(self.past)), *([EFFECTS] if self.effects else [])]


def effects_kept(model: KnitModel, effects: Path | None) -> Path | None:
    """The file with effects of somebody's own, if the model has one of them: a campaign keeps no other beside it."""
    from testbench.knit.catalogue import load_catalogue

    known = load_catalogue().effects
    return None if all(effect.name in known for effect in model.effects.values()) else effects


def motion_of(path: Path, gauge_length_mm: float) -> Motion:
    """What the machine makes of a program; the last few are remembered, by their bytes."""
    return _played(path, sha256_of(path), gauge_length_mm)


@lru_cache(maxsize=8)
def _played(path: Path, sha256: str, gauge_length_mm: float) -> Motion:
    return played(path, gauge_length_mm)[0]


def past_names(count: int) -> list[str]:
    """File names of the earlier programs in a campaign folder, first played first."""
    return [f"before-{number + 1}.tap" for number in range(count)]


def plan_of(folder: Path, effects: Path | None = None) -> Plan:
    """The plan of a simulated campaign, from its manifest and the files beside it.

    Parameters
    ----------
    folder : Path
    effects : Path, optional
        The file with the user's own effects, if the campaign has any. It is asked for, since it is a program that
        will run: one that came with somebody's campaign must not do so unseen.

    Raises
    ------
    UserError
        If the campaign was measured, not simulated, ended early, or a file is no longer the one it was made with.
    """
    from testbench.knit.catalogue import load_catalogue, model_from_dict

    campaign, _ = read_manifest(folder)
    if campaign.origin != "simulated":
        raise UserError(
            f"{folder}: this campaign was {campaign.origin}, only a simulated one can be made again or continued"
        )
    if campaign.status != "complete":
        state = "is unfinished" if campaign.in_progress else f"ended early ({campaign.status})"
        raise UserError(f"{folder}: {state}; only a complete campaign can be made again or continued")
    recipe, program = campaign.recipe, folder / PROGRAM
    digests = recipe.get("past_sha256", [])
    past = tuple(folder / name for name in past_names(len(digests)))
    for path, digest in zip((program, *past), (recipe.get("program_sha256"), *digests), strict=True):
        if not path.is_file() or sha256_of(path) != digest:
            raise UserError(f"{path}: missing or not the program that the manifest names")
    digest = recipe.get("effects_sha256")
    own = None if digest is None else named_effects(folder, folder / EFFECTS, effects, digest)
    model = model_from_dict(recipe.get("model"), load_catalogue(own), str(folder / manifest.NAME))
    rest_s = recipe.get("rest_s", DEFAULT_REST_S)
    if isinstance(rest_s, list) and len(rest_s) != len(past):
        raise UserError(f"{folder}: its manifest names {len(past)} earlier programs and {len(rest_s)} rests")
    return Plan(
        program=program,
        model=model,
        gauge_length_mm=campaign.gauge_length_mm,
        seed=int(recipe["seed"]),
        sensor=recipe["sensor"],
        instruments=Instruments.model_validate(recipe["instruments"]),
        past=past,
        rest_s=tuple(rest_s) if isinstance(rest_s, list) else rest_s,
        effects=own,
    )


def programs_before(
    sources: Iterable[str | Path],
    model: KnitModel,
    gauge_length_mm: float,
    rest_s: float,
    effects: Path | None = None,
) -> tuple[tuple[Path, ...], Rests]:
    """The programs that a sensor went through, from what ``--after`` names, and the rests after them.

    A program rests for `rest_s`. A campaign of this sensor brings what it went through before, as it was then; where
    that is named before it, too, it does not count twice.

    Raises
    ------
    UserError
        If a campaign is of another sensor, gauge length or origin, or of a sensor that went through something else
        than what is named before it: its state cannot be carried on.
    """
    programs: list[Path] = []
    rests_s: list[float] = []
    for source in map(Path, sources):
        if source.is_dir():
            earlier = _continued(source, model, gauge_length_mm, effects)
            if earlier.past:
                if programs and [*map(sha256_of, programs)] != [*map(sha256_of, earlier.past)]:
                    raise UserError(
                        f"{source}: its sensor went through other programs than those that you name before it; name "
                        "the last campaign alone"
                    )
                programs, rests_s = [*earlier.past], np.broadcast_to(earlier.rest_s, len(earlier.past)).tolist()
            programs.append(earlier.program)
        elif source.is_file():
            check_beside(source)
            programs.append(source)
        else:
            raise UserError(f"{source}: no such campaign or program; name what the sensor went through before")
        rests_s.append(rest_s)
    return tuple(programs), tuple(rests_s) if len({*rests_s}) > 1 else rest_s


def _continued(folder: Path, model: KnitModel, gauge_length_mm: float, effects: Path | None) -> Plan:
    """The plan of an earlier campaign, if it is of this sensor."""
    earlier = plan_of(folder, effects)
    if earlier.model.to_dict() != model.to_dict():
        raise UserError(f"{folder}: a campaign of another sensor, {earlier.sensor}; its state cannot go on")
    if earlier.gauge_length_mm != gauge_length_mm:
        raise UserError(
            f"{folder}: its gauge length is {earlier.gauge_length_mm:g} mm, this one's {gauge_length_mm:g} mm; "
            "give `gauge_length_mm`"
        )
    return earlier
