"""What compensators are trained and tested on: fresh specimens of both presets, and pairs of measured recordings.

On pairs of the carbon-black strip (`measured`), of other materials (`others`) and on pairs of other motions and of
another person (`further`) rules of `auto` were compared, so figures on them measure nothing. `unseen` are pairs of
the same recordings, written down before they were run and run once, after everything was chosen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from compensation.paper.paper_campaigns import TAB, campaigns
from compensation.series.preprocessing import TARGETS, Series, series_of
from testbench.recordings.csv_columns import read_columns
from testbench.recordings.files import read_recording
from testbench.recordings.recording import Recording

ALL_REAL = Path(__file__).resolve().parents[1] / "../shared/data/real"
REAL = ALL_REAL / "cb_silicone_strip"
GAUGE_LENGTH_MM, FIRST_PART = 40.0, 0.6
RATE_HZ = 20.0
# Trained on the first, tested on the second: the same strip, the same or another motion, another day or the same.
PAIRS = (
    ("2_multisine_600s", "2_multisine_300s_a"),
    ("2_multisine_600s", "2_random_sawtooth_a"),
    ("2_multisine_300s_a", "2_multisine_600s"),
    ("2_random_sawtooth_a", "2_multisine_300s_a"),
    ("2_triangles_prestrain10_a", "2_triangles_prestrain10_b"),
    ("1_steps4-8-12_v1", "1_steps4-8-12_v2"),
    ("1_steps4-8-12_v2", "1_steps4-8-12_v1"),
    ("2_random_sawtooth_b", "2_triangles12_v19"),
)


# Folder, recordings in turn, and which column is which; a strain and an angle stand for the displacement.
THREAD = {"displacement_mm": "strain_raw", "resistance_ohm": "resistance_rel"}
STRIP = {"displacement_mm": "displacement_mm", "force_N": "force_N", "resistance_ohm": "resistance_ohm"}
OTHERS = (
    ("velostat_pressure", "pike1_exp1", "pike1_exp2", {"force_N": "force_N", "resistance_ohm": "resistance_reading"}),
    ("silver_nylon_thread", "steps_inc_single_1", "steps_inc_single_2", THREAD | {"force_N": "load_raw"}),
    ("silver_nylon_thread", "steps_dec_double_1", "steps_dec_double_2", THREAD | {"force_N": "load_raw"}),
    ("silver_nylon_thread", "steps_inc_single_1", "steps_inc_double_1", THREAD | {"force_N": "load_raw"}),
    ("silver_nylon_thread", "cyclic_mixed_10_20", "cyclic_mixed_15_25", THREAD),
    ("silver_nylon_thread", "cyclic_sin_20", "cyclic_tri_20", THREAD),
)
FURTHER = (
    ("silver_nylon_thread", "steps_inc_double_1", "steps_inc_single_2", THREAD | {"force_N": "load_raw"}),
    ("silver_nylon_thread", "steps_dec_double_1", "steps_inc_single_2", THREAD | {"force_N": "load_raw"}),
    ("silver_nylon_thread", "steps_inc_double_1", "steps_dec_double_2", THREAD | {"force_N": "load_raw"}),
    ("silver_nylon_thread", "cyclic_sin_20", "cyclic_mixed_10_20", THREAD),
    ("silver_nylon_thread", "cyclic_mixed_15_25", "cyclic_sin_20", THREAD),
    ("silver_nylon_thread", "cyclic_tri_20", "cyclic_mixed_15_25", THREAD),
)
FURTHER_STRIP = (
    ("2_multisine_600s", "2_triangles12_v19"),
    ("2_sine", "2_multisine_300s_a"),
    ("2_random_sawtooth_a", "2_multisine_600s"),
)
UNSEEN = (
    ("silver_nylon_thread", "steps_inc_single_2", "steps_inc_double_1", THREAD | {"force_N": "load_raw"}),
    ("silver_nylon_thread", "steps_dec_double_2", "steps_inc_single_1", THREAD | {"force_N": "load_raw"}),
    ("silver_nylon_thread", "steps_inc_double_1", "steps_dec_double_1", THREAD | {"force_N": "load_raw"}),
    ("silver_nylon_thread", "cyclic_mixed_10_20", "cyclic_sin_20", THREAD),
    ("silver_nylon_thread", "cyclic_mixed_15_25", "cyclic_tri_20", THREAD),
    ("silver_nylon_thread", "cyclic_tri_20", "cyclic_mixed_10_20", THREAD),
)
UNSEEN_STRIP = (
    ("2_multisine_300s_a", "2_sine"),
    ("2_random_sawtooth_a", "2_random_sawtooth_b"),
    ("2_triangles12_v19", "2_multisine_600s"),
)
SLEEVE, SLEEVE_SENSORS = "knit_graphene_sleeve/HC_90_S1_2_HC90.csv", ("s1", "s2", "s3", "s4", "s5")
ONE_PERSON = 0.45


@dataclass(frozen=True)
class Case:
    """Recordings to learn from and to be tested on; `load` gives both, in that order."""

    kind: str
    name: str
    load: Callable[[], tuple[Sequence[Recording], Sequence[Recording]]]
    targets: tuple[str, ...] = ("force", "displacement")

    def series(self, target: str) -> list[list[Series]]:
        """The same at `RATE_HZ`: what is learned from, and what is tested on."""
        return [[series_of(one, target, RATE_HZ) for one in half] for half in self.load()]


def simulated(folder: Path, numbers: Sequence[int]) -> Iterator[Case]:
    """T for learning, A and B for the test: consecutive campaigns of one specimen, 23 min each."""

    def load(sensor: str, number: int) -> tuple[Sequence[Recording], Sequence[Recording]]:
        training, *tests = campaigns(folder, sensor, runs=TAB, number=number).values()
        return [training], tests

    for number in numbers:
        for sensor in ("pes", "lycra"):
            yield Case(sensor, f"{sensor}@{number}", lambda s=sensor, n=number: load(s, n))


def real(kinds: Sequence[str]) -> list[Case]:
    """The measured cases of these kinds."""
    every = (*measured(), *others(), *further(), *unseen())
    return [case for case in every if case.kind in kinds]


def material(case: Case) -> str:
    """First word of a measured case's name; the strip's pairs of `measured` have none."""
    return "cb" if case.kind == "measured" else case.name.split()[0]


def measured() -> Iterator[Case]:
    """Pairs of a carbon-black strip whose conductance falls with stretch; nothing where they are absent."""
    if not REAL.is_dir():
        return

    def read(name: str) -> Recording:
        return read_recording(REAL / f"{name}.csv", GAUGE_LENGTH_MM)

    for first, second in PAIRS:
        yield Case(
            "measured",
            f"{first} -> {second}",
            lambda a=first, b=second: ([read(f"cb7.5_s{a}")], [read(f"cb7.5_s{b}")]),
        )

    def halves() -> tuple[Sequence[Recording], Sequence[Recording]]:
        whole = read("cb10_s1_holds8_speeds_v5")
        cut = FIRST_PART * whole.duration_s
        return [whole.between(0.0, cut)], [whole.between(cut, whole.duration_s)]

    yield Case("measured", "cb10 holds, first 60 % -> rest", halves)


def others() -> Iterator[Case]:
    """Pairs of other materials, both ways round, and parts of single recordings; nothing where they are absent."""
    if not ALL_REAL.is_dir():
        return
    for folder, first, second, columns in OTHERS:
        yield _pair("others", folder, first, second, columns)
        yield _pair("others", folder, second, first, columns)
    yield Case("others", "cb sine, first 60 % -> rest", lambda: _parts(read_named(REAL / "cb7.5_s2_sine.csv", STRIP)))
    yield from _sleeve("others", "first 60 % of one person -> rest", (0.0, FIRST_PART * ONE_PERSON, ONE_PERSON))


def further() -> Iterator[Case]:
    """Other motions against one another, and another person; nothing where they are absent."""
    yield from _pairs("further", FURTHER, FURTHER_STRIP)
    begin = 1.0 - ONE_PERSON
    cuts = (begin, begin + FIRST_PART * ONE_PERSON, 1.0)
    yield from _sleeve("further", "first 60 % of another person -> rest", cuts)


def unseen() -> Iterator[Case]:
    """Pairs that were run once, after everything was chosen; nothing where they are absent."""
    yield from _pairs("unseen", UNSEEN, UNSEEN_STRIP)
    yield from _sleeve("unseen", "one person -> another", (0.0, ONE_PERSON, 1.0 - ONE_PERSON, 1.0))


def _pairs(kind: str, pairs: Sequence[tuple], of_the_strip: Sequence[tuple[str, str]]) -> Iterator[Case]:
    if not ALL_REAL.is_dir():
        return
    for folder, first, second, columns in pairs:
        yield _pair(kind, folder, first, second, columns)
    for first, second in of_the_strip:
        yield _pair(kind, REAL.name, f"cb7.5_s{first}", f"cb7.5_s{second}", STRIP)


def _pair(kind: str, folder: str, first: str, second: str, columns: Mapping[str, str]) -> Case:
    def load() -> tuple[Sequence[Recording], Sequence[Recording]]:
        one, other = (read_named(ALL_REAL / folder / f"{name}.csv", columns) for name in (first, second))
        return [one], [other]

    targets = tuple(name for name, (channel, _) in TARGETS.items() if channel in columns)
    return Case(kind, f"{folder.split('_')[0]} {first} -> {second}", load, targets)


def _sleeve(kind: str, what: str, cuts: Sequence[float]) -> Iterator[Case]:
    """Each sensor of the sleeve, learned from between the first two shares of the time, tested between the last two.

    Two people follow each other, the boundary is not marked: the first 45 % are of the first alone, the last of the
    second.
    """
    for sensor in SLEEVE_SENSORS if ALL_REAL.is_dir() else ():
        columns = {"displacement_mm": "knee_angle_deg", "resistance_ohm": f"{sensor}_dR_R0"}

        def load(columns: Mapping[str, str] = columns) -> tuple[Sequence[Recording], Sequence[Recording]]:
            whole = read_named(ALL_REAL / SLEEVE, columns, change=True)
            return [_share(whole, *cuts[:2])], [_share(whole, *cuts[-2:])]

        yield Case(kind, f"sleeve {sensor}, {what}", load, ("displacement",))


def read_named(path: Path, columns: Mapping[str, str], change: bool = False) -> Recording:
    """A recording of these columns; a resistance that is a change against the first counts from 1 on."""
    found = read_columns(path)
    channels = {name: found[column] for name, column in columns.items()}
    channels["resistance_ohm"] = channels["resistance_ohm"] + (1.0 if change else 0.0)
    return Recording(found["time_s"], channels, GAUGE_LENGTH_MM, path.stem)


def _parts(whole: Recording) -> tuple[Sequence[Recording], Sequence[Recording]]:
    """The first 60 % of a recording, and the rest of it."""
    return [_share(whole, 0.0, FIRST_PART)], [_share(whole, FIRST_PART, 1.0)]


def _share(whole: Recording, begin: float, end: float) -> Recording:
    """What lies between two shares of a recording's time."""
    return whole.between(*(float(whole.time_s[0] + share * whole.duration_s) for share in (begin, end)))
