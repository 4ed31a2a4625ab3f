"""The campaigns of a data set, one task each: sensors x programs x seeds."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from gcode.support import strict
from gcode.support.errors import UserError
from gcode.support.files import make_folder, refuse_links, write_text
from testbench.campaigns.datasets.spec import MOST_CAMPAIGNS, DatasetSpec, TrajectoryWish
from testbench.campaigns.plan import Plan, effects_kept, motion_of
from testbench.knit.catalogue import Catalogue, load_catalogue, model_from_dict
from testbench.knit.model import KnitModel
from testbench.knit.presets import preset
from testbench.recordings.instruments import Instruments
from testbench.recordings.stored import FILE_NAME, read_model
from testbench.rig.simulation.played import DEFAULT_REST_S
from testbench.trust import named_effects

PROGRAMS = "programs"


@dataclass(frozen=True)
class Task:
    """One campaign to be made: small, so that it travels to any worker."""

    folder: Path
    program: Path
    sensor: str
    model: dict[str, Any]
    gauge_length_mm: float
    seed: int
    instruments: Instruments
    past: tuple[Path, ...] = ()
    rest_s: float = DEFAULT_REST_S
    effects: Path | None = None
    specimen: str = ""

    def plan(self) -> Plan:
        """The plan of the campaign, from which its manifest is written."""
        model = model_from_dict(self.model, _catalogue(self.effects), self.sensor)
        gauge, tools, seed = self.gauge_length_mm, self.instruments, self.rig_seed
        return Plan(self.program, model, gauge, seed, self.sensor, tools, self.past, self.rest_s, self.effects)

    @property
    def rig_seed(self) -> int:
        """Of its noise and sampling times, which no other campaign has: none of a test were there in training."""
        return int.from_bytes(hashlib.sha256(f"{self.folder.name} {self.seed}".encode()).digest()[:6])


def tasks_of(spec: DatasetSpec, base: Path, out: Path, effects: Path | None = None) -> list[Task]:
    """All campaigns of a data set; programs that have to be planned are written to ``out/programs`` first.

    Parameters
    ----------
    spec : DatasetSpec
    base, out : Path
        Folders of the spec and of the data set.
    effects : Path, optional
        The file with effects of somebody's own, if the spec wants one: named by a person, since it is a program.

    Raises
    ------
    UserError
        If a sensor, a program or a varied parameter is not there, or effects are named here alone: before anything
        runs, not after an hour.
    """
    if effects and not spec.effects:
        raise UserError(f"effects: the spec names none, got {effects}; name the file in the spec, or leave it out")
    own = named_effects(out, base / spec.effects, effects).absolute() if spec.effects else None
    _catalogue(own)  # a file without effects is refused, whether or not a sensor asks for them
    models = {sensor: _model(sensor, base, own) for sensor in spec.sensors}
    kept = {sensor: effects_kept(model, own) for sensor, model in models.items()}
    if spec.trajectory:
        programs = _planned(spec.trajectory, spec.gauge_length_mm, base, out)
    else:
        programs = _found(spec.programs, base)
    for program in programs:
        motion_of(program, spec.gauge_length_mm)
    count = len(models) * len(programs) * len(spec.seeds)
    if count > MOST_CAMPAIGNS:
        raise UserError(f"a data set has at most {MOST_CAMPAIGNS} campaigns, this one would have {count}; split it")
    made = []
    for (sensor, model), (order, program), seed in product(models.items(), enumerate(programs), spec.seeds):
        past = tuple(programs[:order]) if spec.same_sensor else ()
        name = f"{Path(sensor).stem}-{program.stem}-{seed:05d}"
        if name.startswith("_") or not re.fullmatch(FILE_NAME, name):
            raise UserError(
                f"{sensor}, {program}: a campaign would be called {name[:99]!r}; a name has at most 200 characters, "
                "no control characters, and begins with no . or _, which readers of Parquet pass over; rename that "
                "file"
            )
        # Where parameters are drawn by the seed, each seed is a specimen of its own.
        specimen = f"{Path(sensor).stem}#{seed}" if spec.vary else Path(sensor).stem
        drawn = varied(model, spec.vary, specimen).to_dict()
        folder = out.absolute() / name
        gauge = spec.gauge_length_mm
        tools, mine = spec.instruments, kept[sensor]
        made.append(Task(folder, program, sensor, drawn, gauge, seed, tools, past, spec.rest_s, mine, specimen))
    (name, times), *_ = Counter(task.folder.name for task in made).most_common(1)
    if times > 1:
        raise UserError(
            f"{times} campaigns would be called {name}; name each sensor, program and seed once, and give files of "
            "other folders other names"
        )
    return made


def varied(model: KnitModel, ranges: dict[str, tuple[float, float]], specimen: str) -> KnitModel:
    """The model with the parameters in `ranges` drawn uniformly, by the specimen's name; each by its own stream."""
    drawn = {}
    for address, (low, high) in ranges.items():
        stream = np.random.default_rng(list(f"{specimen} {address}".encode()))
        drawn[address] = float(stream.uniform(low, high))
    try:
        return model.with_parameters(drawn) if drawn else model
    except ValueError as error:
        raise UserError(f"vary, {specimen}: {error}") from None


@cache
def _catalogue(effects: Path | None) -> Catalogue:
    return load_catalogue(effects)


def _model(sensor: str, base: Path, effects: Path | None) -> KnitModel:
    if not sensor.endswith(".json"):
        return preset(sensor)
    return model_from_dict(read_model(base / sensor), _catalogue(effects), sensor)


def _found(patterns: Sequence[str], base: Path) -> list[Path]:
    found: list[Path] = []
    for pattern in patterns:
        place, wild = base / pattern, set("*?[")
        if wild & set(str(Path(pattern).parent)) or "**" in pattern:
            # ../../**/*.tap would look through the whole machine, on the word of a file.
            raise UserError(f"{place}: a * may stand in the name of a program, not in its folder's")
        paths = sorted(place.parent.glob(place.name)) if wild & set(place.name) else [place]
        if not paths or not all(path.is_file() for path in paths):
            raise UserError(f"{place}: no such program; make one with `gcode generate`")
        found += (path.absolute() for path in paths)
    return found


def _planned(wish: TrajectoryWish, gauge_length_mm: float, base: Path, out: Path) -> list[Path]:
    from gcode.programs.api import generate
    from gcode.trajectories.presets import preset as motion_preset
    from gcode.trajectories.trajectory import read_spec

    given = motion_preset(wish.preset) if wish.preset else read_spec(base / str(wish.spec))
    folder = (out / PROGRAMS).absolute()
    refuse_links([folder], "choose another place")
    paths = []
    for seed in wish.seeds:
        made = generate(given, seed, gauge_length_mm, duration_s=wish.duration_s)
        path = make_folder(folder) / f"{made.spec.name}-{seed:05d}.tap"
        if not path.is_file() or strict.read_bytes(path, "program") != made.program.encode():
            write_text(path, made.program)
        paths.append(path)
    return paths
