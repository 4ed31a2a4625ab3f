"""Hide effects that no catalogue has, or effects of the catalogue that the search never sees; have a law proposed.

    python benchmarks/bench_propose.py                            every unknown kind once, at 5x and 15x
    python benchmarks/bench_propose.py --rediscover               effects of the catalogue
    python benchmarks/bench_propose.py --results r.jsonl -j 2     resumes where it stopped
    python benchmarks/bench_propose.py --results r.jsonl --report only the tables of what is there

Errors are held-out RMS over the noise floors, the mean of the channels. Some kinds are chance alone (bursts, a loose
wire, lost steps): no law can foretell their next recording, and they are counted all the same.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import worlds_second
from bench_diagnosis import append, read_rows
from diagnosis_score import Row
from joblib import Parallel, delayed

from testbench import worlds
from testbench.comparing.model_errors import over_the_floors
from testbench.proposing import Proposed, propose_law

GOOD = 1.5
BY_CHANCE = {"electrode_detachment", "moisture_bursts", "loose_wire", "lost_steps", "snapping_yarns"}
# Where a mechanism acts, and on what it depends. A law of the strain is as good as one of the force that follows it.
STRETCH = {"strain", "force", "contact force"}
PAST = {"largest strain", "below the largest strain", "past the last top", "from a share of the last top"}
WORN = {"path", "work", "turns", "time"}
MOTION = {"strain rate", "speed", "direction", "force rate", "time since reversal", "time at rest"}
CONTACTS = {"conductance", "contact force", "conductance reading"}
EXPECTED: dict[str, tuple[set[str], set[str]]] = {
    "permanent_set": ({"strain", "force"}, PAST | WORN | {"strain"}),
    "clamp_slip": ({"strain", "force"}, PAST | WORN | {"strain"}),
    "actuator_backlash": ({"strain"}, {"strain", "direction"}),
    "leadscrew_ripple": ({"strain"}, {"strain"}),
    "slack": ({"strain", "force"}, {"strain"}),
    "stress_relaxation": ({"force"}, STRETCH),
    "viscous_rate_stiffening": ({"force"}, {"strain rate", "force rate", "speed", "strain", "force"}),
    "mullins_softening": ({"force"}, PAST),
    "cyclic_fatigue": ({"force"}, WORN),
    "jamming_stiffening": ({"force", "strain"}, {"strain", "force"}),
    "thermal_softening": ({"force"}, {"temperature", "time"}),
    "contact_relaxation": (CONTACTS, STRETCH | {"conductance", "time since reversal", "time at rest", "speed"}),
    "contact_saturation": (CONTACTS, STRETCH | {"conductance"}),
    "electrical_overshoot": (CONTACTS, MOTION | STRETCH | {"conductance"}),
    "rate_resistance": (CONTACTS, MOTION),
    "shoulder_peak": (CONTACTS, STRETCH | PAST | {"direction"}),
    "yarn_elongation": (CONTACTS, STRETCH),
    "coating_wear": (CONTACTS, WORN),
    "coating_cracks": (CONTACTS, PAST),
    "self_heating": (CONTACTS, {"conductance", "heating power", "contact force", "force"}),
    "temperature_drift": (CONTACTS | {"force"}, {"temperature", "time"}),
    "channel_lag": ({"conductance reading", "conductance", "force reading"}, {"conductance", "force rate", "force"}),
    "adc_saturation": ({"conductance reading", "conductance", "force reading"}, {"conductance", "force"}),
    "load_cell_creep": ({"force reading", "force"}, {"force", "time"}),
    "periodic_interference": ({"conductance", "conductance reading", "force", "force reading"}, {"time"}),
}
TIMES = ("tau", "time_s")


@dataclass(frozen=True)
class Job:
    """One case."""

    effect: str
    strength: float
    world: str
    seed: int
    minutes: float = 8.0

    @property
    def key(self) -> str:
        """Names it in a results file."""
        return "/".join(str(value) for value in asdict(self).values())

    def made(self) -> worlds.Case | worlds_second.Case:
        """Its recordings and the truth."""
        if self.world == "second":
            return worlds_second.make_case(self.effect, self.strength, self.seed, minutes=self.minutes)
        return worlds.make_case(self.effect, self.strength, self.world, self.seed, minutes=self.minutes)


def jobs_of(rediscover: bool, strengths: Sequence[float], seeds: Sequence[int], minutes: float) -> list[Job]:
    """Every kind of both simulators, each on a sensor of its own."""
    first = [n for n in worlds.CATALOGUE if n in EXPECTED] if rediscover else list(worlds.OUTSIDE)
    second = [n for n in worlds_second.MECHANISMS if n in EXPECTED] if rediscover else worlds_second.UNKNOWN_KINDS
    jobs = []
    for seed in seeds:
        for strength in strengths:
            for k, name in enumerate(first):
                jobs.append(Job(name, strength, ("matched", "mismatched")[k % 2], 100 * seed + k, minutes))
            jobs += [Job(name, strength, "second", 100 * seed + 50 + k, minutes) for k, name in enumerate(second)]
    order = np.random.default_rng(0).permutation(len(jobs))
    return [jobs[k] for k in order]


def run_job(job: Job) -> Row:
    """Make, propose, score; what raises is a row as well."""
    row: Row = {"key": job.key, **asdict(job)}
    try:
        case = job.made()
        start = time.perf_counter()
        said = propose_law(case.calibration, case.held_out)
    except Exception as error:
        return {**row, "error": f"{type(error).__name__}: {error}"}
    return row | {"seconds": time.perf_counter() - start} | scored(job, case.truth, said)


def scored(job: Job, truth: dict[str, Any], said: Proposed) -> Row:
    """Errors in floors, and whether the first law stands where the hidden one does."""
    floors, laws = said.noise_floor, [law for law, _ in said.laws]
    worst = {k: max(e[c] / floors[c] for c in floors) for k, e in (("b", said.error_before), ("a", said.error_after))}
    row: Row = {
        "verdict": said.verdict,
        "before": over_the_floors(said.error_before, floors),
        "after": over_the_floors(said.error_after, floors),
        "worst_before": worst["b"],
        "worst_after": worst["a"],
        "laws": [law.key for law in laws],
        "values": [dict(law.values) for law in laws],
        "rejected": said.rejected.option.law.key if said.rejected else "",
        "reached": truth["effects"][0]["strength_reached"],
        "form": truth["effects"][0]["form"],
    }
    if job.effect in EXPECTED and laws:
        places, coordinates = EXPECTED[job.effect]
        row["stage"] = laws[0].place.name.removesuffix(" by a share") in places
        row["coordinate"] = laws[0].term.coordinate.name in coordinates
        hidden = truth["effects"][0].get("shape") or truth["effects"][0].get("parameters") or {}
        true = next((hidden[key] for key in TIMES if key in hidden), None)
        if true and "tau_s" in laws[0].values:
            row["time_ratio"] = laws[0].values["tau_s"] / true
    return row


def line_of(row: Row) -> str:
    """One case in one line."""
    name = f"{row['effect']} {row['strength']:g}x {row['world']} {row['seed']}"
    if "error" in row:
        return f"{name}: {row['error']}"
    right = f" stage {row['stage']} coordinate {row['coordinate']}" if "stage" in row else ""
    said = "; ".join(row["laws"]) or f"{row['verdict']} {row['rejected']}"
    return f"{name} -> {row['before']:.2f} -> {row['after']:.2f} floors{right} ({row['seconds']:.0f} s): {said}"


def table(rows: Sequence[Row]) -> str:
    """What the benchmark says of each strength."""
    lines = [f"{'cases':<34}{'n':>4}{'before':>8}{'after':>8}{'<= 1.5':>9}{'worse':>7}{'law':>6}{'seconds':>9}"]
    for strength in sorted({row["strength"] for row in rows}):
        mine = [row for row in rows if row["strength"] == strength and "error" not in row]
        lawful = [row for row in mine if row["effect"] not in BY_CHANCE]
        for name, part in ((f"{strength:g}x", mine), (f"{strength:g}x, not by chance alone", lawful)):
            if part and (part is mine or len(part) < len(mine)):
                lines.append(_line(name, part))
    judged = [row for row in rows if "stage" in row]
    sought = [row for row in rows if row["effect"] in EXPECTED and "error" not in row]
    if sought:
        both = sum(row["stage"] and row["coordinate"] for row in judged)
        lines.append(f"rediscovered: stage and coordinate right in {both} of {len(sought)}")
        lines.append(f"  stage right in {sum(r['stage'] for r in judged)}, a law said in {len(judged)}")
        ratios = np.array([row["time_ratio"] for row in judged if "time_ratio" in row])
        if len(ratios):
            near = int(np.sum(np.abs(np.log(ratios)) < np.log(1.3)))
            lines.append(f"  time constants within 30 %: {near} of {len(ratios)}")
    return "\n".join(lines)


def _line(name: str, rows: Sequence[Row]) -> str:
    after = np.array([row["after"] for row in rows])
    before = np.array([row["before"] for row in rows])
    seconds = np.median([row["seconds"] for row in rows])
    law = np.mean([bool(row["laws"]) for row in rows])
    return (
        f"{name:<34}{len(rows):>4}{np.median(before):>8.2f}{np.median(after):>8.2f}{np.mean(after <= GOOD):>9.0%}"
        f"{int(np.sum(after > before + 1e-9)):>7}{law:>6.0%}{seconds:>9.0f}"
    )


def main() -> None:
    """Run what is asked for and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rediscover", action="store_true", help="effects of the catalogue instead")
    parser.add_argument("--strengths", type=float, nargs="+", default=[15.0, 5.0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    parser.add_argument("--minutes", type=float, default=8.0)
    parser.add_argument("--only", nargs="+", default=[], help="these kinds alone")
    parser.add_argument("--results", type=Path, help="keep the rows here (JSON lines)")
    parser.add_argument("--report", action="store_true", help="run nothing")
    parser.add_argument("-j", type=int, default=1, help="cases side by side")
    args = parser.parse_args()
    jobs = jobs_of(args.rediscover, args.strengths, args.seeds, args.minutes)
    jobs = [job for job in jobs if not args.only or job.effect in args.only]
    known = {row["key"]: row for row in read_rows(args.results)}
    todo = [] if args.report else [job for job in jobs if job.key not in known]
    for row in Parallel(n_jobs=args.j, return_as="generator_unordered")(delayed(run_job)(job) for job in todo):
        known[row["key"]] = row
        if args.results:
            append(args.results, row)
        print(line_of(row), flush=True)
    print(table([known[job.key] for job in jobs if job.key in known]))


if __name__ == "__main__":
    main()
