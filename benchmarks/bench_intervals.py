"""How many errors the interval of `compensation train` holds, at nominal 90 %, on sensors that were not trained on.

    python benchmarks/bench_intervals.py [--trained 411,412,413,414] [--tested 415,416,417,418] [--kinds pes,...]

`auto` learns from campaign T of the trained specimens, of all of them together and of each alone, and predicts
campaign A of the tested ones. Kinds measured, others, unseen: each pair of `compensator_cases`, learned from one
recording.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from compensator_cases import measured, others, unseen
from compensator_rivals import seed_of

from compensation.model.compensator import Compensator
from compensation.paper.paper_campaigns import TAB, campaigns
from compensation.series.preprocessing import TARGETS, Series, series_of
from compensation.training.auto import train_automatically
from compensation.training.options import Options

RATE_HZ, SIMULATED = 20.0, ("pes", "lycra")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trained", default="411,412,413,414", help="numbers of the specimens that are learned from")
    parser.add_argument("--tested", default="415,416,417,418", help="numbers of those that are predicted")
    parser.add_argument("--kinds", default="pes,lycra,measured,others,unseen", help="only these sensors")
    parser.add_argument("--campaigns", type=Path, default=Path(tempfile.gettempdir()) / "knitbench-bench")
    args = parser.parse_args()
    args.campaigns.mkdir(parents=True, exist_ok=True)
    print(f"{'':20} {'learned from':24} share of errors inside: mean (lowest to highest recording)")
    for kind in args.kinds.split(","):
        for target in TARGETS:
            rows = _simulated(args, kind, target) if kind in SIMULATED else _measured(kind, target)
            for name, shares in rows:
                told = f"{np.mean(shares):.2f} ({np.min(shares):.2f} to {np.max(shares):.2f}), {len(shares)} pairs"
                print(f"{kind + ' ' + target:20} {name:24} {told}", flush=True)


def _simulated(args: argparse.Namespace, kind: str, target: str) -> Iterator[tuple[str, list[float]]]:
    learned, tests = (
        [
            series_of(campaigns(args.campaigns, kind, runs=runs, number=int(number))[runs[-1]], target, RATE_HZ)
            for number in numbers.split(",")
        ]
        for numbers, runs in ((args.trained, TAB[:1]), (args.tested, TAB[:2]))
    )
    yield f"{len(learned)} specimens", _inside(train_automatically(learned, target, Options()), tests)
    alone = [_inside(train_automatically([one], target, Options()), tests) for one in learned]
    yield "one specimen", [share for shares in alone for share in shares]


def _measured(kind: str, target: str) -> Iterator[tuple[str, list[float]]]:
    shares: list[float] = []
    for case in (*measured(), *others(), *unseen()):
        if case.kind != kind or target not in case.targets:
            continue
        learned, tests = ([series_of(one, target, RATE_HZ) for one in part] for part in case.load())
        compensator = train_automatically(learned, target, Options(seed=seed_of(case.name, target)))
        shares += _inside(compensator, tests)
    if shares:
        yield "one recording", shares


def _inside(compensator: Compensator, tests: Sequence[Series]) -> list[float]:
    """Of each recording, the share of samples whose truth lies between `low` and `high`."""
    low, high = compensator.margins or (-np.inf, np.inf)
    errors = [part.truth - compensator.predict_series(part) for part in tests]
    return [float(np.mean((low <= error) & (error <= high))) for error in errors]


if __name__ == "__main__":
    main()
