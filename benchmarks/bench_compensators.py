"""`compensation train` against the methods one would try instead, on fresh sensors and on measured recordings.

    python benchmarks/bench_compensators.py [--sets 201,202] [--methods auto,TCN] [--kinds pes,lycra,...] [-j 1]

Every method learns from the same recordings and chooses on them alone. r2 is the paper's, the mean over the held-out
recordings. Each figure is kept in RESULTS as soon as it is known; a benchmark that was stopped goes on from there.
The specimens were drawn for this benchmark alone; `auto` was developed on numbers 101 to 104, and rules of it were
compared on the measured, the other and the further pairs. The unseen pairs chose nothing.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from compensator_cases import Case, material, real, simulated
from compensator_options import MEASURED, SIMULATED, add_campaigns, add_kinds, add_specimens, names
from compensator_rivals import OURS, available, seed_of
from joblib import Parallel, delayed
from result_rows import append, read_rows

from compensation.series import score
from compensation.series.preprocessing import TARGETS, Series

SMALL = 1500
HEADINGS = {
    "measured": "Measured pairs on which rules of auto were compared: r2 on the second, trained on the first",
    "others": "Other materials, on which rules of auto were compared as well: r2 on the second, trained on the first",
    "further": "Other motions and another person, as well: r2 on the second, trained on the first",
    "unseen": "Measured pairs that chose nothing: r2 on the second, trained on the first",
}
# Beside the paper's r2: scored as raw is, by each recording's own mean and spread; as it would be after the best gain
# and level; and the ordinary one. The first two say how much of an error is level and gain.
JUDGES = {"r2_as_raw": score.r2_before, "r2_best_affine": score.rho_squared, "r2_ordinary": score.r2_ordinary}
ROWS = [(kind, target) for kind in SIMULATED for target in TARGETS]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    rivals, notes = available()
    every = (*rivals, *OURS)
    add_specimens(parser, "--sets", "201,202,203,204,205,206", "numbers of the specimens")
    parser.add_argument(
        "--methods", type=names(every), default=every, metavar="NAME,..", help=f"of {', '.join(every)}"
    )
    add_kinds(parser, (*SIMULATED, *MEASURED), (*SIMULATED, *MEASURED))
    add_campaigns(parser)
    parser.add_argument("--results", type=Path, help="default: results.jsonl beside the campaigns")
    parser.add_argument("-j", "--jobs", type=int, default=1)
    args = parser.parse_args()
    results = args.results or args.campaigns / "results.jsonl"
    made = [case for case in simulated(args.campaigns, args.sets) if case.kind in args.kinds]
    cases = [*made, *real(args.kinds)]
    known = read(results)
    jobs = (
        delayed(judged)(case, target, [name for name in args.methods if (case.name, target, name) not in known])
        for case in cases
        for target in case.targets
    )
    for rows in Parallel(n_jobs=args.jobs, return_as="generator")(jobs):
        for row in rows:
            known[row["case"], row["target"], row["method"]] = row
            append(results, row)
    print("\n".join([*tables(known, cases, args.methods), *notes]))


def judged(case: Case, target: str, names: Sequence[str]) -> list[dict]:
    """Train each method on the case and score it."""
    if not names:
        return []
    methods, _ = available()
    training, tests = case.series(target)
    sign = np.sign(np.corrcoef(training[0].conductance_S, training[0].truth)[0, 1])
    raw = float(np.mean([score.r2_before(part.truth, part.conductance_S, sign) for part in tests]))
    rows = []
    for name in names:
        began = time.process_time()
        fitted = {**methods, **OURS}[name](training, target, seed_of(case.name, target))
        predicted = [fitted.predict(part) for part in tests]
        found = float(np.mean([score.r2(part.truth, p) for part, p in zip(tests, predicted, strict=True)]))
        others = {name: _mean(judge, tests, predicted) for name, judge in JUDGES.items()}
        rows.append(
            {
                "case": case.name,
                "kind": case.kind,
                "target": target,
                "method": name,
                "r2": found,
                **others,
                "raw": raw,
                "parameters": fitted.parameters,
                "cpu_s": round(time.process_time() - began, 1),
            }
        )
    return rows


def _mean(judge: Callable[..., float], tests: Sequence[Series], predicted: Sequence[np.ndarray]) -> float:
    return float(np.mean([judge(part.truth, p) for part, p in zip(tests, predicted, strict=True)]))


def read(results: Path) -> dict[tuple[str, str, str], dict]:
    """What is known already: (case, target, method) -> row; a row of an older benchmark, with less in it, is not."""
    rows = (row for row in read_rows(results) if JUDGES.keys() <= row.keys())
    return {(row["case"], row["target"], row["method"]): row for row in rows}


def tables(known: Mapping[tuple[str, str, str], dict], cases: Sequence[Case], methods: Sequence[str]) -> list[str]:
    """The two tables and what they come to."""
    lines: list[str] = []
    if fresh := [case for case in cases if case.kind in SIMULATED]:
        lines += _fresh(known, fresh, methods)
    for kind, heading in HEADINGS.items():
        if pairs := [case for case in cases if case.kind == kind]:
            lines += _pairs(known, pairs, methods, heading)
    return lines


def _fresh(known, cases: Sequence[Case], methods: Sequence[str]) -> list[str]:
    rows = [row for row in ROWS if any(case.kind == row[0] for case in cases)]
    head = "".join(f" {f'{kind} {target}':>26}" for kind, target in rows)
    lines = [
        "Fresh specimens: mean r2 over A and B, trained on T; 95 %: specimens drawn again",
        f"{'method':14}{head} {'mean':>6} {'param.':>7} {'CPU s':>6}",
    ]
    means: dict[str, list[float]] = {}
    for name in methods:
        found = [[known[c.name, target, name] for c in cases if c.kind == kind] for kind, target in rows]
        means[name] = [float(np.mean([one["r2"] for one in column])) for column in found]
        cells = "".join(f" {_with_interval([one['r2'] for one in column]):>26}" for column in found)
        every = [one for column in found for one in column]
        size, cpu = (float(np.median([one[key] for one in every])) for key in ("parameters", "cpu_s"))
        lines.append(f"{name:14}{cells} {np.mean(means[name]):6.3f} {size:7.0f} {cpu:6.1f}")
    raw = [np.mean([known[c.name, t, methods[0]]["raw"] for c in cases if c.kind == kind]) for kind, t in rows]
    lines.append(f"{'raw':14}{''.join(f' {value:26.3f}' for value in raw)} {np.mean(raw):6.3f}")
    return [*lines, *_verdict(known, cases, means), ""]


def _verdict(known, cases: Sequence[Case], means: Mapping[str, Sequence[float]]) -> list[str]:
    small = [
        name
        for name in means
        if name not in OURS and all(known[c.name, t, name]["parameters"] <= SMALL for c in cases for t in TARGETS)
    ]
    if "auto" not in means or not small:
        return []
    best = max(small, key=lambda name: np.mean(means[name]))
    lead = np.mean(means["auto"]) - np.mean(means[best])
    each = np.array(means["auto"]) - np.max([means[name] for name in small], axis=0)
    return [
        f"auto less the best rival of at most {SMALL} parameters ({best}): {lead:+.3f} in the mean; less the best "
        f"one of each column: {', '.join(f'{value:+.3f}' for value in each)}"
    ]


def _pairs(known, cases: Sequence[Case], methods: Sequence[str], heading: str) -> list[str]:
    extra = (
        {"as raw": "r2_as_raw", "affine": "r2_best_affine", "ordinary": "r2_ordinary"} if "auto" in methods else {}
    )
    head = "".join(f" {name[:13]:>13}" for name in ("raw", *methods, *(f"auto {name}" for name in extra)))
    lines, groups = [heading, f"{'pair':56}{head}"], dict[str, list[list[float]]]()
    near, above, as_raw, count = 0, 0, 0, 0
    for case in cases:
        for target in case.targets:
            found = {name: known[case.name, target, name]["r2"] for name in methods}
            raw = known[case.name, target, methods[0]]["raw"]
            more = [known[case.name, target, "auto"][key] for key in extra.values()]
            row = [raw, *found.values(), *more]
            lines.append(f"{f'{case.name}, {target}':56}{_numbers(row)}")
            groups.setdefault(f"{material(case)}, {target}", []).append(row)
            if "auto" in found:
                near += found["auto"] >= max(raw, *found.values()) - 0.01
                above += found["auto"] >= raw
                as_raw += known[case.name, target, "auto"]["r2_as_raw"] >= raw
                count += 1
    groups["all"] = [row for rows in groups.values() for row in rows]
    lines += [
        f"{f'mean of {len(rows)}: {name}':56}{_numbers(np.mean(rows, axis=0))}" for name, rows in groups.items()
    ]
    if count:
        lines.append(
            f"auto is within 0.01 of the best in {near} of {count}, not below raw in {above}, and not below raw in "
            f"{as_raw} where it is scored as raw is, by each recording's own mean and spread"
        )
    return lines


def _numbers(values: Iterable[float]) -> str:
    return "".join(f" {max(value, -9.999):13.3f}" for value in values)


def _with_interval(values: Sequence[float]) -> str:
    rng, array = np.random.default_rng(0), np.array(values)
    low, high = np.quantile(array[rng.integers(len(array), size=(2000, len(array)))].mean(axis=1), [0.025, 0.975])
    return f"{array.mean():.3f} ({low:.3f} to {high:.3f})"


if __name__ == "__main__":
    main()
