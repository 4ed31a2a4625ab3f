"""What a minute of reference buys: campaigns long after the training, and another specimen.

    python benchmarks/bench_recalibration.py [--sets 301,302,303] [--campaigns DIR]
    python benchmarks/bench_recalibration.py --pairs others,further [--seconds 30]

`train --method auto` learns from a specimen's first campaign. Its campaigns 4, 8 and 12, and the fourth of another
specimen of the same kind, are predicted as they are and after `recalibrate` with their first 30 or 60 s, or with
rest: the first reading, held for 10 s, and its force or displacement. Scored is what comes after 60 s, by the
ordinary r2, where an error in level counts in full. `recalibrate` was developed on numbers 101 to 104.

`--pairs` takes measured pairs of `compensator_cases` in place of simulated specimens. Scored is what comes after the
reference: raw (given the mean and the spread of the target there, which nobody in use knows), and a straight line and
`auto`, both trained on the first recording, as they are and after the same reference.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from compensator_cases import RATE_HZ, Case, real
from compensator_options import MEASURED, SIMULATED, add_campaigns, add_specimens, names
from compensator_rivals import seed_of

from compensation.model.compensator import TrainedCompensator
from compensation.model.runtime import ready_for_use
from compensation.paper.paper_campaigns import SEEDS_A_SET, planned, recorded
from compensation.series import score
from compensation.series.preprocessing import TARGETS, Series, series_of
from compensation.training.auto import train_automatically
from compensation.training.learners import linear
from compensation.training.options import Options
from compensation.training.recalibration import recalibrated
from compensation.training.untrained import training_arrays, untrained
from testbench.recordings.recording import Recording

REST_S, FIRST_S = 10.0, 60.0
LATER = (4, 8, 12)
TRAJECTORIES, FIRST_SEED = ("paper-1", "paper-2", "paper-3"), 500  # in turn; of the first campaign, less one
WAYS = ("as it is", "rest", "30 s", "60 s")
PAIR_WAYS = ("raw", "line", "line, ref.", "auto", "auto, rest", "auto, ref.")
JUDGES = (score.r2, score.r2_ordinary)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_specimens(parser, "--sets", "301,302,303", "numbers of the specimens")
    add_campaigns(parser)
    parser.add_argument(
        "--pairs",
        type=names(MEASURED),
        metavar="KIND,..",
        help=f"measured pairs in place of specimens, of {', '.join(MEASURED)}",
    )
    parser.add_argument("--seconds", type=float, default=30.0, help="of reference, for --pairs")
    args = parser.parse_args()
    if args.pairs:
        _report_pairs(real(args.pairs), args.seconds)
        return
    shown = ",".join(map(str, args.sets))
    print(f"ordinary r2 after the first minute, mean (worst) over specimens {shown}")
    print(f"{'':20} {'tested on':20}" + "".join(f" {way:>16}" for way in WAYS))
    for sensor in SIMULATED:
        runs = {number: _campaigns(args.campaigns, sensor, number) for number in args.sets}
        for target in TARGETS:
            series = {n: {w: series_of(r, target, RATE_HZ) for w, r in runs[n].items()} for n in args.sets}
            table: dict[str, list[list[float]]] = {}
            for name, values in _judged(series, target):
                table.setdefault(name, []).append(values)
            for name, rows in table.items():
                found = np.array(rows)
                cells = [f"{m:.3f} ({w:.3f})" for m, w in zip(found.mean(axis=0), found.min(axis=0), strict=True)]
                print(f"{sensor + ' ' + target:20} {name:20}" + "".join(f" {cell:>16}" for cell in cells), flush=True)


def _campaigns(folder: Path, sensor: str, number: int) -> dict[int, Recording]:
    """The first and the later campaigns of a specimen by their numbers; those before each are its past."""
    seeds = {which: FIRST_SEED + which + SEEDS_A_SET * number for which in range(1, LATER[-1] + 1)}
    programs = [
        planned(folder / f"trajectory-age{which}-{number}", TRAJECTORIES[(which - 1) % len(TRAJECTORIES)], seed)
        for which, seed in seeds.items()
    ]
    return {
        which: recorded(
            folder / f"{sensor}-age{which}-{number}",
            programs[which - 1],
            sensor,
            number,
            seeds[which],
            tuple(programs[: which - 1]),
        )
        for which in (1, *LATER)
    }


def _report_pairs(cases: Sequence[Case], seconds: float) -> None:
    print(f"r2 (ordinary r2) of what comes after the first {seconds:g} s")
    print(f"{'pair':62}" + "".join(f" {way:>15}" for way in PAIR_WAYS))
    rows = []
    for case in cases:
        for target in case.targets:
            found = _pair(case, target, seconds)
            if found is None:
                continue
            rows.append(found)
            print(f"{case.name[:48] + ', ' + target:62}" + _cells(found), flush=True)
    if not rows:
        return
    every = np.array(rows)
    raw, line, as_is, after = (
        every[:, PAIR_WAYS.index(way), 0] for way in ("raw", "line, ref.", "auto", "auto, ref.")
    )
    print(f"{f'mean of {len(rows)}':62}" + _cells(every.mean(axis=0)))
    print(
        f"auto after the reference, of {len(rows)}: not below the line after the same in {(after >= line).sum()}, "
        f"not below raw in {(after >= raw).sum()} (as it is: {(as_is >= raw).sum()}), better than as it is in "
        f"{(after > as_is).sum()}"
    )


def _cells(found: np.ndarray) -> str:
    return "".join(f" {f'{paper:.3f} ({usual:.3f})':>15}" for paper, usual in np.maximum(found, -9.999))


def _pair(case: Case, target: str, seconds: float) -> np.ndarray | None:
    """Two scores each way, shape (ways, 2); None where less than half the reference's time would be left."""
    learned, (part, *_) = case.series(target)
    if part.time_s[-1] - part.time_s[0] < 1.5 * seconds:
        return None
    auto = train_automatically(learned, target, Options(seed=seed_of(case.name, target)))
    line, reference = _line(learned, target), _first(part, seconds)
    late = np.arange(len(part)) >= len(reference)
    raw = score.r2_before(part.truth[late], part.conductance_S[late], auto.sign)
    ways = (
        line,
        recalibrated(line, reference),
        auto,
        recalibrated(auto, _at_rest(part)),
        recalibrated(auto, reference),
    )
    scores = [[judge(part.truth[late], one.predict_series(part)[late]) for judge in JUDGES] for one in ways]
    return np.array([[raw, raw], *scores])


def _line(series: Sequence[Series], target: str) -> TrainedCompensator:
    """A straight line through the conductance, as a compensator that can be recalibrated."""
    blank = untrained(series, target, Options(alphas=(1.0,)))
    features, truth = training_arrays(blank, series)
    slope = features.T @ truth / np.sum(features**2)
    return ready_for_use(replace(blank, networks=(linear(slope, 0.0),)), series)


def _judged(series: dict[int, dict[int, Series]], target: str) -> Iterator[tuple[str, list[float]]]:
    numbers = list(series)
    for position, number in enumerate(numbers):
        compensator = train_automatically([series[number][1]], target, Options())
        for which in LATER:
            yield f"campaign {which}", _scores(compensator, series[number][which])
        other = numbers[(position + 1) % len(numbers)]
        if other != number:
            yield "another specimen", _scores(compensator, series[other][LATER[0]])


def _scores(compensator: TrainedCompensator, part: Series) -> list[float]:
    references = (None, _at_rest(part), _first(part, 30.0), _first(part, FIRST_S))
    return [_score(compensator if one is None else recalibrated(compensator, one), part) for one in references]


def _score(compensator: TrainedCompensator, part: Series) -> float:
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
