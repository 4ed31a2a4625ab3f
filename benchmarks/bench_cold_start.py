"""What switching on in mid-use costs: the error from 1 to 20 s after that, over that of one which ran all along.

    python benchmarks/bench_cold_start.py [--sets 901,902] [--kinds pes,lycra,others,further] [--campaigns DIR]

`auto` learns from campaign T of a specimen, or from the first recording of a measured pair (`compensator_cases`). On
the next recording it is switched on at 40 moments, drawn evenly after the first minute. Both root mean squares are
over the same samples. The goal is a ratio of 1.5 at most.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np
from compensator_cases import Case, material, real, simulated
from compensator_options import MEASURED, SIMULATED, add_campaigns, add_kinds, add_specimens
from compensator_rivals import seed_of

from compensation.model.compensator import TrainedCompensator
from compensation.series.preprocessing import Series
from compensation.training.auto import train_automatically
from compensation.training.options import Options

MOMENTS = 40
# In samples: where moments begin, what is looked at after each, and what of it is left out.
AFTER, LOOKED_AT, LEFT_OUT = 1200, 400, 20
GOAL = 1.5


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_specimens(parser, "--sets", "901,902", "numbers of the simulated specimens")
    add_kinds(parser, (*SIMULATED, "others", "further"), (*SIMULATED, *MEASURED))
    add_campaigns(parser)
    args = parser.parse_args()
    cases = [case for case in simulated(args.campaigns, args.sets) if case.kind in args.kinds] + real(args.kinds)
    print(f"{'':66} cold / running")
    ratios: dict[str, list[float]] = {}
    for case in cases:
        for target in case.targets:
            for ratio in _ratio(case, target):
                ratios.setdefault("simulated" if case.kind in SIMULATED else material(case), []).append(ratio)
                print(f"{case.name[:50] + ', ' + target:66} {ratio:.2f}", flush=True)
    for name, found in ratios.items():
        print(
            f"{name}, {len(found)} rows: median {np.median(found):.2f}, largest {max(found):.2f}, "
            f"{sum(ratio > GOAL for ratio in found)} above {GOAL}"
        )


def _ratio(case: Case, target: str) -> Iterator[float]:
    """Cold over running error on the first test of a case; nothing where that is too short."""
    learned, (part, *_) = case.series(target)
    if len(part) < AFTER + 2 * LOOKED_AT:
        return
    trained = train_automatically(learned, target, Options(seed=seed_of(case.name, target)))
    yield cold_over_running(trained.in_use, part)


def cold_over_running(compensator: TrainedCompensator, part: Series) -> float:
    """Ratio of the two errors, each a root mean square over the same samples."""
    running = compensator.predict_series(part) - part.truth
    cold, warm = [], []
    for begin in np.random.default_rng(0).integers(AFTER, len(part) - LOOKED_AT, MOMENTS):
        rows = np.arange(begin, begin + LOOKED_AT)
        fresh = compensator.predict_series(part.rows(rows)) - part.truth[rows]
        cold.append(np.mean(fresh[LEFT_OUT:] ** 2))
        warm.append(np.mean(running[rows][LEFT_OUT:] ** 2))
    return float(np.sqrt(np.mean(cold) / np.mean(warm)))


if __name__ == "__main__":
    main()
