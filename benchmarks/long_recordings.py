"""What a diagnosis of hours takes: memory at most, and processor time, of one pair of recordings.

python benchmarks/long_recordings.py            # 24 h, at 20 Hz; --hours 6 for the shorter pair
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

RATE_HZ = 20.0
DIAGNOSE = """
import re, time
from testbench.cli import main
code = main({words})
most = int(re.search(r"VmHWM:\\s*(\\d+)", open("/proc/self/status").read())[1]) * 1024
print(f"{title}: {{most / 1e9:.2f}} GB at most, {{time.process_time():.0f}} s of one core, exit code {{code}}")
raise SystemExit(code)
"""


def main() -> int:
    """Write the pair and diagnose it; the last line says what that took."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=24.0)
    hours = parser.parse_args().hours
    sys.path.insert(0, str(Path(__file__).parents[1]))
    os.environ["OMP_NUM_THREADS"] = "1"
    import testbench as tb
    from tests.testbench.builders import record, truth, write_csv

    hidden = truth() + tb.effects.StressRelaxation(fraction=0.3)
    with tempfile.TemporaryDirectory() as folder:
        pair = [
            str(write_csv(record(hidden, hours * 3600, RATE_HZ, seed=seed), Path(folder) / f"{seed}.csv"))
            for seed in (1, 2)
        ]
        words = ["diagnose", pair[0], "--held-out", pair[1], "--gauge-length-mm", "25"]
        code = DIAGNOSE.format(words=words, title=f"a pair of {hours:g} h at {RATE_HZ:g} Hz")
        return subprocess.run([sys.executable, "-c", code], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
