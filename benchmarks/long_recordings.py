"""What a diagnosis of hours takes: memory at most, clock and processor time, of one pair of recordings.

python benchmarks/long_recordings.py            # 24 h, at 20 Hz; --hours 6 for the shorter pair
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import testbench as tb
from tests.testbench.builders import record, truth, write_csv

RATE_HZ = 20.0
LOOK_EVERY_S = 0.2


def main() -> int:
    """Write the pair and diagnose it; the last line says what that took."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=24.0)
    hours = parser.parse_args().hours
    os.environ["OMP_NUM_THREADS"] = "1"
    hidden = truth() + tb.effects.StressRelaxation(fraction=0.3)
    with tempfile.TemporaryDirectory() as folder:
        pair = [
            str(write_csv(record(hidden, hours * 3600, RATE_HZ, seed=seed), Path(folder) / f"{seed}.csv"))
            for seed in (1, 2)
        ]
        words = ["diagnose", pair[0], "--held-out", pair[1], "--gauge-length-mm", "25"]
        begun = time.monotonic()
        running = subprocess.Popen([Path(sys.executable).with_name("testbench"), *words])
        most = 0
        while running.poll() is None:
            held, then = memory_of(running.pid), memory_of(running.pid)
            if held.keys() == then.keys():  # else what a process has that just began, or ended, may count twice
                most = max(most, sum(then.values()))
            time.sleep(LOOK_EVERY_S)
    took_s, used = time.monotonic() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    print(
        f"a pair of {hours:g} h at {RATE_HZ:g} Hz: {most / 1e9:.2f} GB at most, {took_s:.0f} s by the clock, "
        f"{used.ru_utime + used.ru_stime:.0f} s of one core, exit code {running.returncode}"
    )
    return running.returncode


def memory_of(pid: int) -> dict[int, int]:
    """Bytes that a process and all that it started hold, by number; of what n of them share each holds 1 / n."""
    try:
        rollup = Path(f"/proc/{pid}/smaps_rollup").read_text()
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:  # it has just ended
        return {}
    own = next((int(line.split()[1]) for line in rollup.splitlines() if line.startswith("Pss:")), 0)
    return {pid: own * 1024} | {key: held for child in children for key, held in memory_of(int(child)).items()}


if __name__ == "__main__":
    raise SystemExit(main())
