"""What `compensation train` promises of another day, and what comes: all ordered pairs of a sensor's recordings.

    python benchmarks/compensator_promises.py [--only strip_1,strip_2,steps,cyclic,velostat]

`auto` learns from one measured recording and predicts each other one of the same sensor. Printed are r2 as
cross-validation promises it, the same "with the gain and zero of another day", and what comes.
"""

from __future__ import annotations

import argparse

import numpy as np
from compensator_cases import ALL_REAL, OTHERS, RATE_HZ, STRIP, THREAD, read_named
from compensator_options import names

from compensation.series.preprocessing import TARGETS, series_of
from compensation.series.score import r2
from compensation.training.auto import train_automatically
from compensation.training.options import Options

SENSORS = {
    "strip_1": ("cb_silicone_strip/cb7.5_s1_*.csv", STRIP),
    "strip_2": ("cb_silicone_strip/cb7.5_s2_*.csv", STRIP),
    "steps": ("silver_nylon_thread/steps_*.csv", THREAD | {"force_N": "load_raw"}),
    "cyclic": ("silver_nylon_thread/cyclic_*.csv", THREAD),
    "velostat": ("velostat_pressure/*.csv", OTHERS[0][-1]),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", type=names(tuple(SENSORS)), default=tuple(SENSORS), metavar="NAME,..")
    rows = [row for name in parser.parse_args().only for row in promises(name)]
    if not rows:
        parser.error(f"no measured recordings in {ALL_REAL}")
    for told, found in (("means", np.mean(rows, axis=0)), ("medians", np.median(rows, axis=0))):
        print(f"{told} of {len(rows)}: promised {found[0]:.3f}, of another day {found[1]:.3f}, came {found[2]:.3f}")


def promises(sensor: str) -> list[list[float]]:
    """The two promises and what came, of each ordered pair and target."""
    pattern, columns = SENSORS[sensor]
    recordings, rows = [read_named(path, columns) for path in sorted(ALL_REAL.glob(pattern))], []
    for target in (name for name, (channel, _) in TARGETS.items() if channel in columns):
        series = [series_of(recording, target, RATE_HZ) for recording in recordings]
        for part in series:
            auto = train_automatically([part], target, Options())
            promise = auto.recipe["cross_validated"]
            for other in series:
                if other is not part:
                    came = r2(other.truth, auto.predict_series(other))
                    rows.append([promise["r2"], promise["r2_elsewhere"], came])
                    print(
                        f"{f'{part.source} -> {other.source}, {target}':80} "
                        + "{:.3f} {:.3f} {:.3f}".format(*rows[-1])
                    )
    return rows


if __name__ == "__main__":
    main()
