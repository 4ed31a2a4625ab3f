"""How near the laws of each mechanism come to those of a simulator that shares none with them.

    python benchmarks/law_coverage.py --simulator second --seeds 303            every mechanism, on sensors of its own
    python benchmarks/law_coverage.py --seeds 303:306 --only stress_relaxation

Each sensor hides one effect, and the search has the laws of that mechanism alone. What it leaves of either channel is
told in noise floors, without and with the best law: 1.25 is all that a law is asked for. Where a mechanism stays far
above that, the catalogue lacks a law (or the base does), whatever the diagnosis says. Nothing is held out here.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from bench_diagnosis import EFFECTS, Job, jobs_of, seeds_in

from testbench.diagnosis.diagnosis import calibration_and_held_out
from testbench.diagnosis.searching.search import searched
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.knit.catalogue import Catalogue, load_catalogue

SHOWN = 3  # laws of a mechanism


def line_of(job: Job, catalogue: Catalogue) -> str:
    """One sensor: what is left without and with the mechanism, and which of its laws came nearest."""
    case = job.made()
    measurement, _ = calibration_and_held_out([case.calibration], case.held_out)
    laws = {n: law for n, law in catalogue.effects.items() if law.in_base or law.mechanism == job.effect}
    search, rounds, _ = searched(measurement, Catalogue(laws, {}), 1)
    before, entries = rounds[0].before, rounds[0].entries
    form = case.truth["effects"][0]["form"]
    told = [f"{job.effect}/{form}", str(job.seed), left(before.hypothesis, search.likelihood)]
    told.append(left(entries[0].hypothesis, search.likelihood) if entries else "no law")
    told += [f"{e.law} {e.log_z - before.log_z:+.0f}" for e in entries[:SHOWN]]
    return " | ".join(told)


def left(h: Hypothesis, likelihood: Likelihood) -> str:
    """What a model leaves of each channel, in noise floors."""
    return ", ".join(f"{c} {sigma / likelihood.floor[c]:.2f}" for c, sigma in h.evidence.sigma.items())


def main(argv: Sequence[str] | None = None) -> None:
    """Print a line for each sensor."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--simulator", choices=[one for one in EFFECTS if one != "first"], default="second")
    parser.add_argument("--seeds", type=seeds_in, default=[0], help="such as 0:5")
    parser.add_argument("--strength", type=float, default=15.0, help="in noise floors")
    parser.add_argument("--minutes", type=float, default=6.0, help="length of the recording")
    parser.add_argument("--only", default="", help="these mechanisms (commas between)")
    args = parser.parse_args(argv)
    catalogue, like = load_catalogue(), Job(minutes=args.minutes)
    jobs = jobs_of(EFFECTS[args.simulator], [args.strength], [args.simulator], args.seeds, like)
    wanted = set(args.only.split(",")) if args.only else set(catalogue.mechanisms())
    print("mechanism/form | seed | left without | left with | laws and what they add, in nats")
    for job in jobs:
        if job.effect in wanted and not job.left_out:
            print(line_of(job, catalogue), flush=True)


if __name__ == "__main__":
    main()
