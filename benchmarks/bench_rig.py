"""The rig: a 23 min campaign simulated, verified and read; lines per second; import of a large CSV.

python benchmarks/bench_rig.py [ROWS_TO_IMPORT]
"""

from __future__ import annotations

import sys
import tempfile
import timeit
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gcode.programs.make import make
from gcode.trajectories.presets import preset as trajectory_preset
from testbench.campaigns.campaign import simulate_campaign
from testbench.campaigns.plan import Plan
from testbench.importing.from_file import import_file
from testbench.importing.wish import Wish
from testbench.knit.presets import preset
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import problems
from testbench.rig.protocol.stream import Intake
from testbench.rig.simulation.played import played


def seconds(work: Callable[[], object]) -> float:
    """Best of three runs."""
    return min(timeit.repeat(work, number=1, repeat=3))


def accepted(lines: list[bytes]) -> int:
    """Lines through a fresh intake."""
    intake = Intake()
    for line in lines:
        for _ in intake.feed(line, 0.0):
            pass
    return intake.accepted


def campaign(folder: Path) -> None:
    """One campaign of the paper, step by step."""
    program = folder / "program.tap"
    made = make(trajectory_preset("paper-1"), 51, 25.0)
    program.write_text(made.program)
    motion, gauge_length_mm = played(program)
    wish = Plan(program, preset("pes"), gauge_length_mm, 1, "pes")
    names = iter(range(1000))
    rig = wish.rig(motion)
    rig.truth()  # compiled by now
    whole_s = seconds(lambda: simulate_campaign(wish, folder / f"c{next(names)}", motion))
    lines = list(rig.lines())
    intake_s = seconds(lambda: accepted(lines))
    print(f"campaign: {motion.duration_s / 60:.1f} min, {len(lines)} samples")
    print(f"  model on the 200 Hz grid      {seconds(rig.truth):8.3f} s")
    print(f"  plan to campaign folder       {whole_s:8.3f} s   {motion.duration_s / whole_s:8.0f} x real time")
    print(f"  decode and accept             {intake_s:8.3f} s   {len(lines) / intake_s:8.0f} lines/s")
    print(f"  verify every byte             {seconds(lambda: problems(folder / 'c0')):8.3f} s")
    print(f"  read_recording                {seconds(lambda: read_recording(folder / 'c0')):8.3f} s")


def large_import(folder: Path, rows: int) -> None:
    """A foreign CSV of many rows."""
    path = folder / "large.csv"
    time_s = np.arange(rows) * 0.001
    block = np.column_stack([time_s, np.sin(time_s), np.cos(time_s), 1e3 + np.sin(time_s)])
    with path.open("w") as stream:
        stream.write("t,x,F,R\n")
        for part in np.array_split(block, max(1, rows // 100_000)):
            stream.write("%.3f,%.5f,%.5f,%.3f\n" * len(part) % tuple(part.ravel()))
    wish = Wish(25.0, units={"time": "s", "displacement": "mm", "force": "N", "resistance": "ohm"})
    start_s = timeit.default_timer()
    (imported,) = import_file(path, wish)
    import_s = timeit.default_timer() - start_s
    size_MB = path.stat().st_size / 1e6
    print(f"import: {len(imported.recording)} rows, {size_MB:.0f} MB: {import_s:.1f} s, {rows / import_s:.2g} rows/s")


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as scratch:
        campaign(Path(scratch))
        large_import(Path(scratch), int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000)


if __name__ == "__main__":
    main()
