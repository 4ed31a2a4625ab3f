"""Effects that are taken for each other, hidden in simulated sensors: how long until an investigation is sure?

    python benchmarks/bench_investigate.py                                  a taste: 2 cases
    python benchmarks/bench_investigate.py --cases 14 --results r.jsonl     each side of each pair once; resumes
    python benchmarks/bench_investigate.py --results r.jsonl --report       only the table of what is there

One arm begins with a bit of everything and goes on with the motion that is expected to tell most; the other is random
motion like the paper's. Sensors are those of `testbench.worlds`: they share nothing with the model.
Strength is what the sensor's own base laws cannot absorb, over the noise floor, in random motion of `--run-minutes`.
"""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from result_rows import Row, append, read_rows

from gcode.support.files import copy_file, make_folder
from testbench.campaigns.plan import PROGRAM
from testbench.campaigns.record import Job
from testbench.diagnosis.judging.probabilities import NOTHING
from testbench.investigating import loop
from testbench.investigating.benches import Order
from testbench.investigating.state import Investigation, Settings
from testbench.knit.catalogue import load_catalogue
from testbench.recordings.files import write_recording_csv
from testbench.recordings.manifest import Campaign, write_manifest
from testbench.recordings.versions import software_versions
from testbench.rig.acquisition.recorder import Limits
from testbench.rig.simulation.played import past_displacement, played
from testbench.worlds.sensor import HiddenSensor

ARMS = ("designed", "perlin")
# Effects that are taken for each other; of backlash and jamming the other side is that nothing is missing.
PAIRS = (
    ("permanent_set", "clamp_slip:slides_above_threshold"),
    ("electrical_overshoot", "contact_relaxation"),
    ("self_heating", "temperature_drift"),
    ("actuator_backlash", "none"),
    ("load_cell_creep", "stress_relaxation"),
    ("jamming_stiffening", "none"),
    ("contact_saturation", "adc_saturation"),
)
SETTLED_HZ = 200.0


@dataclass(frozen=True)
class WorldBench:
    """The tester with a hidden sensor in it."""

    sensor: HiddenSensor
    keeps_time: bool = False

    def run(self, order: Order, report: Any = None, stopped: Callable[[], bool] = lambda: False) -> None:
        """Make the campaign of an order."""
        motion, gauge_mm = played(order.program, order.gauge_length_mm)
        earlier = [played(path, gauge_mm)[0] for path in order.past]
        past = past_displacement(earlier, order.rest_s) / gauge_mm
        thin = 4
        recording = self.sensor.recording(
            motion.time_s, motion.displacement_mm / gauge_mm, past[::thin], thin / SETTLED_HZ, order.seed
        )
        shutil.rmtree(order.folder, ignore_errors=True)
        make_folder(order.folder)
        write_recording_csv(order.folder / "recording.csv", recording)
        copy_file(order.program, order.folder / PROGRAM)
        recipe = Job("hidden", 115200, order.program, gauge_mm, Limits(), "hidden").recipe()
        made = Campaign(gauge_mm, "recorded", "complete", recipe, {"samples": len(recording)}, software_versions())
        write_manifest(order.folder, made, ["recording.csv", PROGRAM])


def cases_of(count: int, seed: int) -> list[tuple[str, str, int]]:
    """Hidden effect, base world and seed: sides of the pairs in turn, each case with a sensor of its own."""
    found = []
    for number in range(count):
        turn, place = divmod(number, len(PAIRS))
        world = "matched" if (place + turn // 2) % 2 == 0 else "mismatched"
        found.append((PAIRS[place][(place + turn) % 2], world, 1000 * seed + number))
    return found


def run_case(effect: str, world: str, seed: int, args: argparse.Namespace, folder: Path) -> list[Row]:
    """Both arms of one case."""
    name, _, form = effect.partition(":")
    rows = []
    try:
        sensor = HiddenSensor(name, args.strength, world, seed, args.run_minutes, form=form or None)
        answer = sensor.names[0] if sensor.names else NOTHING
        bench, catalogue = WorldBench(sensor), load_catalogue()
        for arm in ARMS:
            start = time.perf_counter()
            place = folder / f"{seed}-{arm}"
            settings = Settings(
                bounds={"duration_s": 60 * args.run_minutes},
                budget_s=60 * args.budget_minutes,
                motion=arm,
                trials=args.trials,
                seed=seed % 100_000,
                effects_at_most=args.repeat,
            )
            loop.begin(place, settings, "hidden")
            ended = loop.proceed(place, bench, catalogue)
            row = row_of(effect, world, seed, arm, answer, ended, time.perf_counter() - start, args)
            rows.append(row | {"reached": sensor.reached})
    except Exception as error:  # a case that fails is a row too: it must not stop the others
        rows.append(
            {"key": f"{effect}/{world}/{seed}/error", "effect": effect, "error": f"{type(error).__name__}: {error}"}
        )
    return rows


def row_of(
    effect: str, world: str, seed: int, arm: str, answer: str, ended: Investigation, seconds: float, args: Any
) -> Row:
    """One arm of a case."""
    beliefs = [run.belief for run in ended.runs if run.belief is not None]
    top, chance = beliefs[-1].top
    return {
        "key": f"{effect}/{world}/{seed}/{arm}",
        "effect": effect,
        "world": world,
        "seed": seed,
        "arm": arm,
        "answer": answer,
        "strength": args.strength,
        "run_minutes": args.run_minutes,
        "budget_minutes": args.budget_minutes,
        "runs": len(beliefs),
        "motion_min": ended.spent_s / 60,
        "ended": ended.ended,
        "said": top,
        "chance": chance,
        "of_answer": [belief.probabilities.get(answer, 0.0) for belief in beliefs],
        "tops": [list(belief.top) for belief in beliefs],
        "motions": [run.words for run in ended.runs],
        "expected": [[run.expected_nats, run.perlin_nats] for run in ended.runs],
        "seconds": seconds,
    }


def line_of(row: Row) -> str:
    """One arm in one line."""
    if "error" in row:
        return f"{row['key']}: {row['error']}"
    path = ", ".join(f"{name} {100 * chance:.0f} %" for name, chance in row["tops"])
    right = "right" if row["said"] == row["answer"] else "wrong"
    return (
        f"{row['effect']} ({row['world']} {row['seed']}), {row['arm']}: {row['ended']} after {row['motion_min']:.1f} "
        f"min, {right}: {path} | {row['seconds']:.0f} s"
    )


def table(rows: Sequence[Row]) -> str:
    """Time to 95 % and how many were right, arm by arm; what was never sure counts as longer than any that was."""
    good = [row for row in rows if "error" not in row]
    lines = [f"{'motion':<10}{'cases':>6}{'sure':>6}{'right':>7}{'right of sure':>15}{'median time to 95 %':>22}"]
    for arm in ARMS:
        own = [row for row in good if row["arm"] == arm]
        if not own:
            continue
        sure = [row for row in own if row["ended"] == loop.SURE]
        right = [row for row in own if row["said"] == row["answer"]]
        both = [row for row in sure if row["said"] == row["answer"]]
        times = [row["motion_min"] if row["ended"] == loop.SURE else np.inf for row in own]
        median = float(np.median(times))
        said = f"{median:.1f} min" if np.isfinite(median) else "more than the budget"
        share = f"{len(both)} of {len(sure)}"
        lines.append(f"{arm:<10}{len(own):>6}{len(sure):>6}{len(right):>7}{share:>15}{said:>22}")
    first = [row for row in good if row["arm"] == ARMS[0]]
    lines.append(f"sure after the first run already: {sum(row['runs'] == 1 for row in first)} of {len(first)}")
    lines.append(f"failed: {len(rows) - len(good)}")
    return "\n".join(lines)


def arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    """What to run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=2, metavar="N", help="hidden cases (2); 14 is one of each side")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--strength", type=float, default=3.0, help="over the noise floor (3)")
    parser.add_argument("--run-minutes", type=float, default=2.0, help="length of each run (2)")
    parser.add_argument("--budget-minutes", type=float, default=12.0, help="of motion (12)")
    parser.add_argument("--trials", type=int, default=16, help="motions weighed for each run, beside the named (16)")
    parser.add_argument("--repeat", type=int, default=1, help="effects found at most in a diagnosis (1)")
    parser.add_argument("--results", type=Path, help="JSON lines to append to and to resume from")
    parser.add_argument("--report", action="store_true", help="print the table of --results and run nothing")
    parser.add_argument("-j", "--jobs", type=int, default=1, help="processes")
    return parser.parse_args(argv)


def main(argv: Sequence[str] | None = None) -> None:
    """Run what was asked for and print the table."""
    args = arguments(argv)
    rows = read_rows(args.results)
    if not args.report:
        done = {row.get("seed") for row in rows if "error" not in row}
        todo = [case for case in cases_of(args.cases, args.seed) if case[2] not in done]
        with TemporaryDirectory(prefix="knitbench-") as temporary:
            made = Parallel(n_jobs=args.jobs, return_as="generator_unordered")(
                delayed(run_case)(*case, args, Path(temporary)) for case in todo
            )
            for count, arms in enumerate(made, 1):
                for row in arms:
                    rows.append(row)
                    print(f"{count}/{len(todo)} {line_of(row)}", flush=True)
                    if args.results is not None:
                        append(args.results, row)
    print("\n" + table(rows))


if __name__ == "__main__":
    main()
