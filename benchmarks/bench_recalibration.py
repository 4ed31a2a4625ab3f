"""What a minute of reference buys: campaigns long after the training, and another specimen.

    python benchmarks/bench_recalibration.py [--sets 301,302,303] [--campaigns DIR]

`train --method auto` learns from a specimen's first campaign. Its campaigns 4, 8 and 12, and the fourth of another
specimen of the same kind, are predicted as they are and after `recalibrate` with their first 30 or 60 s, or with
rest: the first reading, held for 10 s, and its force or displacement. Scored is what comes after 60 s, by the
ordinary r2, where an error in level counts in full. `recalibrate` was developed on numbers 101 to 104.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from compensator_ageing import chain

from compensation.model.compensator import Compensator
from compensation.series import score
from compensation.series.preprocessing import TARGETS, Series, series_of
from compensation.training.auto import train_automatically
from compensation.training.options import Options
from compensation.training.recalibration import recalibrated

RATE_HZ, REST_S, FIRST_S = 20.0, 10.0, 60.0
LATER = (4, 8, 12)
WAYS = ("as it is", "rest", "30 s", "60 s")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", default="301,302,303", help="numbers of the specimens")
    parser.add_argument("--campaigns", type=Path, default=Path(tempfile.gettempdir()) / "knitbench-bench")
    args = parser.parse_args()
    args.campaigns.mkdir(parents=True, exist_ok=True)
    numbers = [int(number) for number in args.sets.split(",")]
    print(f"ordinary r2 after the first minute, mean (worst) over specimens {args.sets}")
    print(f"{'':20} {'tested on':20}" + "".join(f" {way:>16}" for way in WAYS))
    for sensor in ("pes", "lycra"):
        runs = {number: chain(args.campaigns, sensor, number, (1, *LATER)) for number in numbers}
        for target in TARGETS:
            series = {n: {w: series_of(r, target, RATE_HZ) for w, r in runs[n].items()} for n in numbers}
            table: dict[str, list[list[float]]] = {}
            for name, values in _judged(series, target):
                table.setdefault(name, []).append(values)
            for name, rows in table.items():
                found = np.array(rows)
                cells = [f"{m:.3f} ({w:.3f})" for m, w in zip(found.mean(axis=0), found.min(axis=0), strict=True)]
                print(f"{sensor + ' ' + target:20} {name:20}" + "".join(f" {cell:>16}" for cell in cells), flush=True)


def _judged(series: dict[int, dict[int, Series]], target: str) -> Iterator[tuple[str, list[float]]]:
    numbers = list(series)
    for position, number in enumerate(numbers):
        compensator = train_automatically([series[number][1]], target, Options())
        for which in LATER:
            yield f"campaign {which}", _scores(compensator, series[number][which])
        other = numbers[(position + 1) % len(numbers)]
        if other != number:
            yield "another specimen", _scores(compensator, series[other][LATER[0]])


def _scores(compensator: Compensator, part: Series) -> list[float]:
    references = (None, _at_rest(part), _first(part, 30.0), _first(part, FIRST_S))
    return [_score(compensator if one is None else recalibrated(compensator, one), part) for one in references]


def _score(compensator: Compensator, part: Series) -> float:
    late = part.time_s >= part.time_s[0] + FIRST_S
    return score.r2_ordinary(part.truth[late], compensator.predict_series(part)[late])


def _first(part: Series, seconds: float) -> Series:
    return part.rows(np.flatnonzero(part.time_s < part.time_s[0] + seconds))


def _at_rest(part: Series) -> Series:
    """Campaigns begin at rest, ten minutes after the one before."""
    time_s = np.arange(0.0, REST_S, 1.0 / RATE_HZ)
    held = np.ones(len(time_s))
    return Series(time_s, held * part.conductance_S[0], held * part.truth[0], part.source)


if __name__ == "__main__":
    main()
