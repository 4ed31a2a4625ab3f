"""Public measured recordings that the diagnosis is held against: what they are, and what is known of each material.

The recordings are not part of this repository, whose licence theirs need not allow; their folder is given by name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import testbench as tb
from testbench.recordings.recording import Recording

Recordings = tuple[list[Recording], Recording | None]
Reader = Callable[[Path], Recordings]

RELAXING = ("stress_relaxation", "viscous_rate_stiffening")
CARBON = ("electrical_overshoot", "contact_relaxation", "contact_creep", "stress_relaxation", "mullins_softening")

PULLS = (1, 2, 3, 4, 5)  # of each fabric
PLAY_MM = 1.0  # of the jaws, as ISO 13934-1 allows


@dataclass(frozen=True)
class Pair:
    """A recording to diagnose, and one to hold out.

    Attributes
    ----------
    key, title : str
    read : callable
        From the material's folder to the recordings that are calibrated on, in turn, and the one that is held out;
        the latter is None where that is the last third.
    clamp_play_mm : float
        Where the specimen was clamped anew for each recording.
    """

    key: str
    title: str
    read: Reader
    clamp_play_mm: float = 0.0


@dataclass(frozen=True)
class Material:
    """One material.

    Attributes
    ----------
    folder, title, source, licence : str
    known : str
        What is known of it, in a few sentences.
    plausible : tuple of str
        Mechanisms that agree with it; ``nothing`` where none is expected.
    pairs : tuple of Pair
    """

    folder: str
    title: str
    source: str
    licence: str
    known: str
    plausible: tuple[str, ...]
    pairs: tuple[Pair, ...]


def table(path: Path) -> dict[str, np.ndarray]:
    """Columns of a CSV by name."""
    found = np.genfromtxt(path, delimiter=",", names=True, encoding="utf-8")
    return {name: np.asarray(found[name], dtype=float) for name in found.dtype.names or ()}


def recording(columns: dict[str, np.ndarray], gauge_length_mm: float, source: str) -> Recording:
    """The columns that a diagnosis reads; rows whose time does not go on, or that hold no number, are left out."""
    names = ("time_s", "displacement_mm", "force_N", "resistance_ohm")
    kept = {name: columns[name] for name in names if name in columns}
    good = np.all([np.isfinite(values) for values in kept.values()], axis=0)
    if "resistance_ohm" in kept:
        good &= kept["resistance_ohm"] > 0
    good &= kept["time_s"] > np.maximum.accumulate(np.r_[-np.inf, kept["time_s"][:-1]])
    made = tb.read({name: values[good] for name, values in kept.items()}, gauge_length_mm=gauge_length_mm)
    return Recording(made.time_s, made.channels, made.gauge_length_mm, source)


def _files(made: Callable[[dict[str, np.ndarray], str], Recording], one: str, other: str | None = None) -> Reader:
    """A recording a file, made of its columns and its name; the other one is held out."""

    def read(folder: Path) -> Recordings:
        both = [made(table(folder / f"{name}.csv"), name) for name in (one, other) if name]
        return both[:1], both[1] if other else None

    return read


def _of_length(gauge_mm: float, one: str, other: str | None = None) -> Reader:
    """Files of one gauge length."""
    return _files(lambda columns, name: recording(columns, gauge_mm, name), one, other)


def _strip(one: str, other: str | None = None) -> Reader:
    """Carbon-black strips: 40 mm between the clamps."""
    return _of_length(40.0, one, other)


def _by_strain(one: str, other: str) -> Reader:
    """Files that tell displacement and strain: their ratio is the gauge length."""

    def made(columns: dict[str, np.ndarray], name: str) -> Recording:
        top = int(np.argmax(columns["strain"]))
        return recording(columns, float(columns["displacement_mm"][top] / columns["strain"][top]), name)

    return _files(made, one, other)


def _repeats(name: str, *pulls: int) -> Reader:
    """Fabrics: pulls of one specimen in turn, each with its own zero; the last is held out."""

    def read(folder: Path) -> Recordings:
        columns = table(folder / f"{name}.csv")
        gauge_mm = float((columns["length_mm"] - columns["displacement_mm"])[0])
        made = []
        for number in pulls:
            rows = columns["repeat"] == number
            own = {key: values[rows] for key, values in columns.items()}
            made.append(recording(own, gauge_mm, f"{name}, pull {number}"))
        return made[:-1], made[-1]

    return read


def _thread(one: str, other: str | None = None) -> Reader:
    """Nylon thread: strain, load and R/R0; 100 mm and 1 ohm stand for what is not told."""

    def made(raw: dict[str, np.ndarray], name: str) -> Recording:
        load = {"force_N": raw["load_raw"]} if "load_raw" in raw else {}
        columns = {"displacement_mm": 100.0 * raw["strain_raw"], "resistance_ohm": raw["resistance_rel"], **load}
        return recording({"time_s": raw["time_s"], **columns}, 100.0, name)

    return _files(made, one, other)


def _sleeve(name: str) -> Reader:
    """Knee sleeve: the angle of the knee stands for the stretch, one of five sensors."""

    def made(raw: dict[str, np.ndarray], name: str) -> Recording:
        columns = {"displacement_mm": raw["knee_angle_deg"], "resistance_ohm": 1 + raw["s1_dR_R0"]}
        return recording({"time_s": raw["time_s"], **columns}, 100.0, f"{name}, sensor 1")

    return _files(made, name)


MATERIALS: Sequence[Material] = (
    Material(
        "vhb4910_elastomer",
        "Acrylic elastomer VHB 4910",
        "github.com/Chongran-Zhao/VHB4910_data, commit a23efd8c",
        "none stated",
        "A textbook viscoelastic solid: stress relaxation over decades of time and loops that depend on the rate. No "
        "slipping clamp and no failing load cell is known.",
        RELAXING,
        (
            Pair("vhb-relax", "ramp and hold, stretch 2.5, then 2.0", _by_strain("relax_2d5", "relax_2d0")),
            Pair(
                "vhb-cycles", "one cycle at 0.03 /s, then at 0.01 /s", _by_strain("cycle_0d03_2d5", "cycle_0d01_2d0")
            ),
        ),
    ),
    Material(
        "cb_silicone_strip",
        "Carbon black in silicone, strip",
        "github.com/richgumy/electromech-stretcher, commit ab6634c8",
        "none stated",
        "Conductance falls with stretch, overshoots at every step of the strain, and settles for minutes after it, "
        "for particle networks break and heal. The silicone relaxes and softens with its first stretch.",
        CARBON,
        (
            Pair(
                "cb-steps",
                "steps of 4, 8 and 12 mm, twice",
                _strip("cb7.5_s1_steps4-8-12_v1", "cb7.5_s1_steps4-8-12_v2"),
            ),
            Pair(
                "cb-prestrained",
                "triangles over a pre-strain, twice",
                _strip("cb7.5_s2_triangles_prestrain10_a", "cb7.5_s2_triangles_prestrain10_b"),
            ),
            Pair(
                "cb-multisine",
                "multisine of 600 s, then of 300 s",
                _strip("cb7.5_s2_multisine_600s", "cb7.5_s2_multisine_300s_a"),
            ),
            Pair("cb-sawtooth", "random sawtooth", _strip("cb7.5_s2_random_sawtooth_a")),
            Pair("cb-speeds", "holds at eight speeds, 10 % carbon", _strip("cb10_s1_holds8_speeds_v5")),
        ),
    ),
    Material(
        "cb_silicone_strip",
        "Silicone without carbon",
        "github.com/richgumy/electromech-stretcher, commit ab6634c8",
        "none stated",
        "The control of the strips above: force alone. Silicone relaxes a little, and softens with its first "
        "stretch.",
        (*RELAXING, "mullins_softening", "cyclic_fatigue"),
        (Pair("silicone", "holds at eight speeds", _strip("cb0_control_holds8_speeds_v2")),),
    ),
    Material(
        "knit_fabric_uniaxial",
        "Plain knitted fabrics",
        "github.com/sabetta/stitch-by-stitch, commit 0ed27f35",
        "MIT",
        "Five pulls of a specimen. The first differs from the others: the force falls by 11 to 42 % (softening with"
        " the largest strain so far, permanent set), with loops of friction. A slipping clamp would jump.",
        ("mullins_softening", "permanent_set", "cyclic_fatigue", *RELAXING),
        (
            Pair(
                "garter", "acrylic garter, pulls 1 to 4, then 5", _repeats("acrylic_yarn_garter_x", *PULLS), PLAY_MM
            ),
            Pair(
                "stockinette",
                "cotton stockinette, pulls 1 to 4, then 5",
                _repeats("pearlized_cotton_stockinette_x", *PULLS),
                PLAY_MM,
            ),
        ),
    ),
    Material(
        "silver_nylon_thread",
        "Silver-coated polyamide thread",
        "github.com/vistormu/catasta, commits 396e139d and 43843c2f",
        "MIT",
        "Resistance rises with stretch and settles after it; the polymer relaxes. Filtered and thinned by its "
        "authors, units of load not told: 1 ohm stands for R0, and 100 mm for the length.",
        (*CARBON, "viscous_rate_stiffening", "permanent_set", "coating_cracks", "coating_wear"),
        (
            Pair("thread-steps-up", "rising steps, twice", _thread("steps_inc_single_1", "steps_inc_single_2")),
            Pair("thread-steps-down", "falling steps, twice", _thread("steps_dec_double_1", "steps_dec_double_2")),
            Pair("thread-triangles", "triangles of 20 mHz", _thread("cyclic_tri_20")),
        ),
    ),
    Material(
        "extra_rubber_relax_24h",
        "Rubber, one hold of 24 h",
        "github.com/russelmann/temporal-morphing-ncomms, commit d735547b",
        "none stated",
        "Stress relaxation over five decades of time. Its gauge length is not told; 25 mm stand for it.",
        RELAXING,
        (Pair("rubber-hold", "one ramp and a hold", _of_length(25.0, "rubber_relax_24h")),),
    ),
    Material(
        "knit_graphene_sleeve",
        "Graphene-coated knit on a knee sleeve",
        "github.com/e-Body-Lab/graphene-based-knitted-sensing-sleeve, commit 47369aba",
        "MIT",
        "No tensile test: the angle of the knee stands for the stretch, two wearers follow each other in one file, "
        "and the sleeve slides on the skin. No one mechanism is expected to explain it: `unknown` is the honest "
        "answer.",
        ("unknown",),
        (Pair("sleeve", "walking, sensor 1", _sleeve("HC_90_S1_2_HC90")),),
    ),
)


def all_pairs() -> dict[str, tuple[Material, Pair]]:
    """Every pair by its key."""
    return {pair.key: (material, pair) for material in MATERIALS for pair in material.pairs}
