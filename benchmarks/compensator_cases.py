"""What compensators are trained and tested on: fresh specimens of both presets, and pairs of measured recordings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from compensation.paper.paper_campaigns import TAB, campaigns
from testbench.recordings.files import read_recording
from testbench.recordings.recording import Recording

REAL = Path(__file__).resolve().parents[1] / "../shared/data/real/cb_silicone_strip"
GAUGE_LENGTH_MM, FIRST_PART = 40.0, 0.6
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


@dataclass(frozen=True)
class Case:
    """Recordings to learn from and to be tested on; `load` gives both, in that order."""

    kind: str
    name: str
    load: Callable[[], tuple[Sequence[Recording], Sequence[Recording]]]


def simulated(folder: Path, numbers: Sequence[int]) -> Iterator[Case]:
    """T for learning, A and B for the test: consecutive campaigns of one specimen, 23 min each."""

    def load(sensor: str, number: int) -> tuple[Sequence[Recording], Sequence[Recording]]:
        training, *tests = campaigns(folder, sensor, runs=TAB, number=number).values()
        return [training], tests

    for number in numbers:
        for sensor in ("pes", "lycra"):
            yield Case(sensor, f"{sensor}@{number}", lambda s=sensor, n=number: load(s, n))


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
