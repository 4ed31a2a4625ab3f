"""Which constants of the diagnosis matter: each is halved and doubled, and the answers are looked at.

    python benchmarks/ablation.py --simulator second --seeds 228 --minutes 6 --results a.jsonl
    python benchmarks/ablation.py --simulator second --seeds 228 --minutes 6 --results a.jsonl --search INDEPENDENT
    python benchmarks/ablation.py --results a.jsonl --report

Most constants only judge: the search is done once a case, and all that it refitted is judged anew with each of them
changed. Of probabilities the odds are halved and doubled. Constants that the fits use, too, take a search of their
own for each value; name them with --search. The cases are those of `bench_diagnosis.py --quick`.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from bench_diagnosis import EFFECTS, OF_ONE_WORLD, Job, catalogue_for, jobs_of, line_of, scored
from diagnosis_score import at_a_glance, goals, markdown
from result_rows import Row, append, read_rows

from testbench.diagnosis.conclusion import concluded
from testbench.diagnosis.judging.entries import Entry
from testbench.diagnosis.judging.probabilities import NOTHING, UNKNOWN
from testbench.diagnosis.judging.put_in import whole_of
from testbench.diagnosis.judging.rounds import Round
from testbench.diagnosis.searching.search import Search, searched
from testbench.fitting import constants
from testbench.measurements.splitting import split

PROBABILITIES = ("PRIOR_NOTHING", "PRIOR_UNKNOWN", "MISLED")
JUDGING = (
    *PROBABILITIES,
    "EVIDENCE_ERROR",
    "LAW_ERROR",
    "LAW_SPREAD",
    "NOISE_SPREAD",
    "INEXACT",
    "LEAST_MISFIT",
    "MOST_LEFT",
)
EVERY = tuple(name for name, value in vars(constants).items() if name.isupper() and isinstance(value, int | float))
MISFIT = ("INEXACT", "LEAST_MISFIT")  # those that enter the evidences, too
TIMES = (0.5, 2.0)
SHOWN = (
    "right first and named",
    "in the top three",
    "nothing hidden, and nothing said",
    "of no catalogue, and unknown said",
    "a wrong name with more than 90 %",
    "expected calibration error",
)


@contextmanager
def changed(name: str, times: float) -> Iterator[None]:
    """A constant, or the odds of a probability, times a factor."""
    before = getattr(constants, name)
    after = before * times
    if name in PROBABILITIES:
        odds = times * before / (1 - before)
        after = odds / (1 + odds)
    setattr(constants, name, max(round(after), 1) if isinstance(before, int) else after)
    try:
        yield
    finally:
        setattr(constants, name, before)


def answers_of(job: Job, search_for: Sequence[str]) -> Row:
    """One case: the row of `bench_diagnosis.py`, and what would have been said with each constant changed."""
    case, catalogue, start = job.made(), catalogue_for(job), time.perf_counter()
    calibration, held = split(case.calibration, case.held_out)
    search, rounds, put_in = searched(calibration, catalogue, constants.ROUNDS)
    told = concluded(search, rounds, put_in, calibration, held).to_dict()
    row = {"key": job.key, "simulator": job.simulator, **asdict(job)}
    row |= scored(job, case, told, time.perf_counter() - start)
    changes = {}
    for name in JUDGING:
        for times in TIMES:
            with changed(name, times):
                steps = [weighed_anew(search, step) if name in MISFIT else replace(step) for step in rounds]
                changes[f"{name} {times:g}"] = answer(steps, put_in_of(steps, put_in))
    for name in search_for:
        for times in TIMES:
            with changed(name, times):
                found = searched(calibration, catalogue, constants.ROUNDS)
                changes[f"{name} {times:g}"] = answer(*found[1:])
    return row | {"changes": changes}


def weighed_anew(search: Search, step: Round) -> Round:
    """The same with all evidences as the constants are now."""
    entries = [search.judged(e, step.likelihood) for e in step.entries]
    before = search.judged(step.before, step.likelihood)
    return replace(step, before=before, entries=tuple(sorted(entries, key=lambda e: -e.log_z)))


def put_in_of(steps: Sequence[Round], put_in: Sequence[Entry]) -> list[Entry]:
    """What was put in, as it is weighed now."""
    return [next(e for e in step.entries if e.law == one.law) for step, one in zip(steps, put_in, strict=False)]


def answer(rounds: Sequence[Round], put_in: Sequence[Entry]) -> dict[str, Any]:
    """The verdict, the name that comes first, and the probabilities, as far as they enter the tables."""
    step = rounds[0]
    same = bool(put_in) and step.candidate is not None and step.candidate.mechanism == put_in[0].mechanism
    whole = whole_of(rounds, put_in) if same else None
    verdict, chances = step.verdict(whole), step.doubted(whole)
    ranked = sorted((name for name in chances if name not in (NOTHING, UNKNOWN)), key=lambda name: -chances[name])
    named = [step.candidate.mechanism] if verdict == "missing" and step.candidate else []
    sure = [chances[name] for name in named]
    return {"verdict": verdict, "named": named, "sure": sure, "chances": chances, "ranked": ranked[:5]}


def table(rows: Sequence[Row]) -> str:
    """What each change makes of the figures, as Markdown."""
    goals_now = goals(rows)
    lines = [["as they are", "", "", *(goals_now[name] for name in SHOWN)]]
    for change in dict.fromkeys(name for row in rows for name in row["changes"]):
        name, times = change.split()
        then = goals([row | row["changes"][change] for row in rows if change in row["changes"]])
        lines.append([f"`{name}`", f"{getattr(constants, name):g}", times, *(then[shown] for shown in SHOWN)])
    return markdown(["constant", "value", "times", *SHOWN], lines)


def main() -> None:
    """Run what is not in the results yet, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--simulator", choices=tuple(OF_ONE_WORLD), default="second", help="who makes the sensors")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0], help="of the sensors")
    parser.add_argument("--minutes", type=float, default=6.0, help="length of each recording (6)")
    parser.add_argument("--limit", type=int, help="stop after so many cases")
    parser.add_argument(
        "--search", nargs="*", default=[], choices=EVERY, metavar="CONSTANT", help="search anew with these changed"
    )
    parser.add_argument("--results", type=Path, required=True, help="JSON lines to append to and to resume from")
    parser.add_argument("--report", action="store_true", help="only the tables of what is there")
    args = parser.parse_args()
    rows = {row["key"]: row for row in read_rows(args.results)}
    jobs = jobs_of(EFFECTS[args.simulator], [5.0], [args.simulator], args.seeds, Job(minutes=args.minutes))
    for job in [] if args.report else jobs[: args.limit]:
        if job.key not in rows:
            rows[job.key] = answers_of(job, args.search)
            append(args.results, rows[job.key])
            print(line_of(rows[job.key]), flush=True)
    print(f"\n{at_a_glance(list(rows.values()))}\n\n{table(list(rows.values()))}")


if __name__ == "__main__":
    main()
