"""What `compensation train` promises of another recording, beside what comes.

    python benchmarks/compensator_promises.py [--sets 901,902] [--kinds pes,lycra,others,...] [--campaigns DIR]

`auto` learns from one recording of each case of `compensator_cases` and is scored on those it is tested on. Printed
are the cross-validated r2, the one to expect with the gain and zero of another day or specimen, and the r2 that comes.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from compensator_cases import Case, real, simulated
from compensator_rivals import seed_of

from compensation.series import score
from compensation.series.preprocessing import series_of
from compensation.training.auto import train_automatically
from compensation.training.options import Options

RATE_HZ = 20.0
COLUMNS = ("promised", "elsewhere", "comes", "ordinary")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", default="901,902", help="numbers of the simulated specimens")
    parser.add_argument("--kinds", default="pes,lycra,measured,others,further,unseen", help="only these sensors")
    parser.add_argument("--campaigns", type=Path, default=Path(tempfile.gettempdir()) / "knitbench-bench")
    args = parser.parse_args()
    args.campaigns.mkdir(parents=True, exist_ok=True)
    numbers, kinds = [int(number) for number in args.sets.split(",")], args.kinds.split(",")
    cases = [case for case in simulated(args.campaigns, numbers) if case.kind in kinds] + real(args.kinds)
    print(f"{'':62}" + "".join(f" {name:>9}" for name in COLUMNS))
    rows = []
    for case in cases:
        for target in case.targets:
            rows.append(_row(case, target))
            print(f"{case.name[:48] + ', ' + target:62}" + _cells(rows[-1]), flush=True)
    if rows:
        print(f"{f'mean of {len(rows)}':62}" + _cells(np.mean(rows, axis=0)))
        print(f"{'median':62}" + _cells(np.median(rows, axis=0)))


def _row(case: Case, target: str) -> np.ndarray:
    """The columns of one case; of several tests the mean."""
    learned, tests = ([series_of(one, target, RATE_HZ) for one in half] for half in case.load())
    trained = train_automatically(learned, target, Options(seed=seed_of(case.name, target)))
    promise = trained.recipe["cross_validated"]
    scores = [
        [judge(part.truth, trained.predict_series(part)) for judge in (score.r2, score.r2_ordinary)] for part in tests
    ]
    return np.array([promise["r2"], promise["r2_elsewhere"], *np.mean(scores, axis=0)])


def _cells(values: np.ndarray) -> str:
    return "".join(f" {value:9.3f}" for value in values)


if __name__ == "__main__":
    main()
