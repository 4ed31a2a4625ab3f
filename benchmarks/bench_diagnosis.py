"""Hide effects in simulated sensors and see whether the diagnosis finds them, and is as sure as it may be.

    python benchmarks/bench_diagnosis.py                                 a taste: 6 cases
    python benchmarks/bench_diagnosis.py --simulator second --minutes 8  the same on the second, independent simulator
    python benchmarks/bench_diagnosis.py --simulator third --quick       on the third: final figures, not to tune by
    python benchmarks/bench_diagnosis.py --simulator fourth --quick      on the fourth: not to tune by either
    python benchmarks/bench_diagnosis.py --quick                         every effect once, at 5x
    python benchmarks/bench_diagnosis.py --full --results r.jsonl -j 2   everything; resumes where it stopped
    python benchmarks/bench_diagnosis.py --results r.jsonl --report      only the tables of what is there
    python benchmarks/bench_diagnosis.py --kinds 60 --seeds 4 -j 2       short, slow, clamped anew, ...: any kind
    python benchmarks/bench_diagnosis.py --simulator second --laws elasticity=fung --quick
                                                                         on the law that was left out of tuning

Strength is what the simulated sensor's own base laws cannot absorb, over the noise floor; in the fourth simulator it
is over 5 mN and 4e-3 in ln G. The noise of the second, third and fourth simulator is that of the paper's rig (5 mN,
8e-4 in ln G); --noise 3 makes it three times that.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import worlds_fourth
import worlds_second
import worlds_third
from diagnosis_score import Row, score, tables
from joblib import Parallel, delayed
from result_rows import append, read_rows
from simulated_case import Case, laws_of

from gcode.support.errors import UserError
from testbench import worlds
from testbench.diagnosis import diagnose
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.recordings.channels import FORCE, RESISTANCE
from testbench.recordings.recording import Recording
from testbench.worlds.base import WORLDS
from testbench.worlds.motions import PROTOCOLS

Diagnose = Callable[..., Any]  # of the two recordings, a catalogue and, if clamped anew, `clamp_play_mm`
AnyCase = worlds.Case | Case
# Simulators of one world each, named as they are: every seed draws its laws anew, noise 1 is that of the paper's rig.
OF_ONE_WORLD = {"second": worlds_second, "third": worlds_third, "fourth": worlds_fourth}
FREELY_ASKED = ("second", "third")  # for sensors of some laws only, and for one that was clamped anew
LATER = ("laws", "reclamped")  # fields of a job that the keys of older results lack
CLAMPED_ANEW = 0.25  # share of recordings of any kind
PAIRS = (
    "stress_relaxation,channel_lag",
    "permanent_set,electrical_overshoot",
    "mullins_softening,self_heating",
    "viscous_rate_stiffening,adc_saturation",
    "clamp_slip,contact_relaxation",
)
EFFECTS = {"first": list(worlds.CATALOGUE)} | {name: one.MECHANISMS for name, one in OF_ONE_WORLD.items()}
OUTSIDE = {"first": list(worlds.OUTSIDE)} | {name: one.UNKNOWN_KINDS for name, one in OF_ONE_WORLD.items()}
MOTIONS = {"first": sorted(PROTOCOLS)} | {name: sorted(one.PROTOCOLS) for name, one in OF_ONE_WORLD.items()}


@dataclass(frozen=True)
class Job:
    """One case to diagnose."""

    effect: str = "none"
    strength: float = 5.0
    world: str = "matched"
    seed: int = 0
    left_out: bool = False
    minutes: float = 23.0
    rate_hz: float = 40.0
    noise: str = ""  # that of the simulator: any kind in the first, of the paper's rig in the others
    protocol: str = "perlin"
    channels: str = f"{FORCE},{RESISTANCE}"
    laws: str = ""  # of the simulator's sensors, if not all: see `simulated_case.laws_of`
    reclamped: bool = False

    @property
    def simulator(self) -> str:
        """Which of them makes it."""
        return self.world if self.world in OF_ONE_WORLD else "first"

    @property
    def key(self) -> str:
        """Names the case; rows of a results file are found again by it."""
        told = asdict(self)
        asked = [told.pop(name) for name in LATER]
        return "/".join(str(value) for value in [*told.values(), *filter(None, asked)])

    def made(self) -> AnyCase:
        """Its two recordings and the truth."""
        how = {"minutes": self.minutes, "rate_hz": self.rate_hz, "protocol": self.protocol}
        channels = self.channels.split(",")
        if self.simulator in OF_ONE_WORLD:
            make = OF_ONE_WORLD[self.simulator].make_case
            how |= {name: value for name in LATER if (value := getattr(self, name))}
            return make(
                self.effect, self.strength, self.seed, noise=float(self.noise or 1.0), channels=channels, **how
            )
        return worlds.make_case(
            self.effect, self.strength, self.world, self.seed, noise=self.noise or "any", channels=channels, **how
        )


def jobs_of(
    effects: Sequence[str], strengths: Sequence[float], worlds: Sequence[str], seeds: Sequence[int], like: Job = Job()
) -> list[Job]:
    """Every effect in turn, none, unknown, effects left out of the catalogue and pairs, evenly shuffled.

    Every case has a sensor of its own: were they to share one, its luck would decide about all. A run that is broken
    off has seen a bit of everything.
    """
    jobs: list[Job] = []
    for world in worlds:
        kinds = OUTSIDE[Job(world=world).simulator]
        for seed in seeds:
            sensors = itertools.count(1000 * seed)
            outside = [kinds[(2 * seed + k) % len(kinds)] for k in (0, 1)]
            left_out, pair = effects[seed * 7 % len(effects)], PAIRS[seed % len(PAIRS)]
            jobs += [Job(effect, s, world, seed=next(sensors)) for effect in effects for s in strengths]
            jobs += [Job("none", strengths[0], world, next(sensors)) for _ in range(3)]
            for s in (s for s in strengths if s >= 5):
                jobs += [Job(name, s, world, next(sensors)) for name in (*outside, pair)]
                jobs.append(Job(left_out, s, world, next(sensors), left_out=True))
    order = np.random.default_rng(0).permutation(len(jobs))
    how = {"minutes": like.minutes, "rate_hz": like.rate_hz, "noise": like.noise}
    return [replace(jobs[k], protocol=usual_motion(jobs[k].simulator), **how) for k in order]


def usual_motion(simulator: str) -> str:
    """That of the paper's recordings (`Job.protocol`), or the first that the simulator has."""
    return Job.protocol if Job.protocol in MOTIONS[simulator] else MOTIONS[simulator][0]


ON_FORCE = (
    "stress_relaxation",
    "viscous_rate_stiffening",
    "mullins_softening",
    "cyclic_fatigue",
    "jamming_stiffening",
    "permanent_set",
    "clamp_slip",
    "actuator_backlash",
    "load_cell_creep",
)
OF_ONE_READING = ("load_cell_creep", "periodic_interference", "channel_lag", "adc_saturation")


def kinds_of(count: int, seed: int, simulator: str = "first", noise: str = "") -> list[Job]:
    """Cases of any kind: how long, how often sampled, which motion, channels, sensor, if clamped anew, all drawn."""
    rng = np.random.default_rng(seed)
    choice = [simulator] if simulator in OF_ONE_WORLD else sorted(WORLDS)

    def drawn(number: int) -> Job:
        effect = str(rng.choice([*EFFECTS[simulator], "none", "none", "none"]))
        world, protocol = str(rng.choice(choice)), str(rng.choice(MOTIONS[simulator]))
        channels = [f"{FORCE},{RESISTANCE}"] * 2
        # Only where the effect can be seen: contacts of carbon black feel no force, some faults are of one reading.
        channels += [FORCE] if effect in ON_FORCE or effect == "none" else []
        unfelt = world == "carbon_black" and effect in ON_FORCE
        channels += [RESISTANCE] if not unfelt and effect not in OF_ONE_READING else []
        return Job(
            effect,
            float(rng.choice([5, 10])),
            world,
            1000 * seed + number,
            minutes=float(rng.choice([5, 10, 23])),
            rate_hz=float(rng.choice([12, 40, 100])),
            noise=noise,
            protocol=protocol,
            channels=str(rng.choice(channels)),
        )

    again = np.random.default_rng([seed, 1])  # of its own: what is drawn above stays as it was before
    can = simulator in FREELY_ASKED
    return [replace(drawn(k), reclamped=bool(can and again.random() < CLAMPED_ANEW)) for k in range(count)]


def run_job(job: Job, diagnose: Diagnose) -> Row:
    """Make the case, diagnose it, score it. A diagnosis that raises is a row too: it must not stop the others."""
    row: Row = {"key": job.key, "simulator": job.simulator, **asdict(job)}
    try:
        case, catalogue = job.made(), catalogue_for(job)
        start = time.perf_counter()
        clamps = {"clamp_play_mm": case.clamp_play_mm} if isinstance(case, Case) and case.clamp_play_mm else {}
        said = diagnose(case.calibration, case.held_out, catalogue, **clamps).to_dict()
    except Exception as error:
        return {**row, "error": f"{type(error).__name__}: {error}"}
    return row | scored(job, case, said, time.perf_counter() - start)


def catalogue_for(job: Job) -> Catalogue:
    """What the diagnosis may know: all effects, or all but the one that is left out."""
    catalogue = load_catalogue()
    return catalogue.without(mechanisms().get(job.effect, job.effect)) if job.left_out else catalogue


def mechanisms() -> dict[str, str]:
    """Law of the whole catalogue -> the mechanism that it belongs to."""
    return {name: effect.mechanism for name, effect in load_catalogue().effects.items()}


def scored(job: Job, case: AnyCase, said: Mapping[str, Any], seconds: float) -> Row:
    """What `Diagnosis.to_dict()` was worth."""
    expected = "unknown" if job.left_out else case.truth["verdict"]
    row = {"noise_kind": case.truth["noise_kind"], "seconds": seconds}
    return row | score(case.truth, said, expected, mechanisms())


def run_all(jobs: Sequence[Job], diagnose: Diagnose, results: Path | None, workers: int) -> list[Row]:
    """Rows of all jobs; those that `results` has already are not run again."""
    rows = {row["key"]: row for row in read_rows(results)}
    todo = [job for job in jobs if job.key not in rows]
    made: Iterator[Row] = Parallel(n_jobs=workers, return_as="generator_unordered")(
        delayed(run_job)(job, diagnose) for job in todo
    )
    for count, row in enumerate(made, 1):
        rows[row["key"]] = row
        if results is not None:
            append(results, row)
        print(f"{count}/{len(todo)} {line_of(row)}", flush=True)
    return [rows[job.key] for job in jobs]


def line_of(row: Row) -> str:
    """One case in one line."""
    name = (
        f"{row['effect']}{' (left out)' if row['left_out'] else ''} {row['strength']:g}x {row['world']} {row['seed']}"
    )
    if "error" in row:
        return f"{name}: {row['error']}"
    sure = max(row["chances"].values(), default=float("nan"))
    said = f"{row['verdict']} ({100 * sure:.0f} %): {', '.join(row['found'] or row['ranked'][:3])}"
    return f"{name} -> {said} | {row['before']:.2f} -> {row['after']:.2f} floors, {row['seconds']:.0f} s"


def the_diagnosis(
    calibration: Recording, held_out: Recording, catalogue: Catalogue, clamp_play_mm: float = 0.0
) -> Any:
    """The one of this repository."""
    return diagnose(calibration, held_out, catalogue=catalogue, clamp_play_mm=clamp_play_mm)


def arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    """What to run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--simulator", choices=("first", *OF_ONE_WORLD), default="first", help="who makes the sensors"
    )
    parser.add_argument("--quick", action="store_true", help="every effect once, at 5x")
    parser.add_argument("--full", action="store_true", help="every effect, strengths 2, 5, 15, 5 seeds")
    parser.add_argument("--effects", help="only these (commas between)")
    parser.add_argument("--minutes", type=float, default=23.0, help="length of each recording (23, as the paper's)")
    parser.add_argument("--rate-hz", type=float, default=40.0, help="samples a second (40)")
    parser.add_argument("--noise", default="", help="first: white, any, ...; others: times that of the paper's rig")
    parser.add_argument("--strengths", type=_numbers, help="such as 2,5,15")
    parser.add_argument(
        "--worlds", default="matched,mismatched", help="of the first simulator: matched,...,carbon_black"
    )
    parser.add_argument(
        "--laws",
        default="",
        help="second, third: only sensors with these laws (elasticity=fung,ogden), or without (elasticity!=fung)",
    )
    parser.add_argument("--seeds", type=seeds_in, help="such as 0:5")
    parser.add_argument("--kinds", type=int, metavar="N", help="N recordings of any kind instead")
    parser.add_argument("--limit", type=int, help="stop after so many cases")
    parser.add_argument("--results", type=Path, help="JSON lines to append to and to resume from")
    parser.add_argument("--report", action="store_true", help="print the tables of --results and run nothing")
    parser.add_argument("-j", "--jobs", type=int, default=1, help="processes")
    args = parser.parse_args(argv)
    if args.laws and args.simulator not in FREELY_ASKED:
        parser.error(f"--laws: only for --simulator {' or '.join(FREELY_ASKED)}, not {args.simulator}")
    if args.laws:
        try:
            laws_of(args.laws, OF_ONE_WORLD[args.simulator].LAW_FAMILIES)
        except UserError as error:
            parser.error(f"--{error}")
    return args


def _numbers(text: str) -> list[float]:
    return [float(part) for part in text.split(",")]


def seeds_in(text: str) -> list[int]:
    """Seeds as they are given: one, or the first and the one after the last (``0:5``)."""
    start, _, end = text.partition(":")
    return list(range(int(start), int(end))) if end else [int(start)]


def main(argv: Sequence[str] | None = None) -> None:
    """Run what was asked for and print the tables."""
    args = arguments(argv)
    if args.report:
        print(tables(read_rows(args.results)))
        return
    strengths = args.strengths or ([2.0, 5.0, 15.0] if args.full else [5.0])
    seeds = args.seeds or (list(range(5)) if args.full else [0])
    if args.kinds:
        jobs = [job for seed in seeds for job in kinds_of(args.kinds, seed, args.simulator, args.noise)]
    else:
        effects = args.effects.split(",") if args.effects else EFFECTS[args.simulator]
        worlds = [args.simulator] if args.simulator in OF_ONE_WORLD else args.worlds.split(",")
        like = Job(minutes=args.minutes, rate_hz=args.rate_hz, noise=args.noise)
        jobs = jobs_of(effects, strengths, worlds, seeds, like)
    taste = 6 if not (args.quick or args.full or args.kinds or args.seeds or args.strengths) else None
    jobs = [replace(job, laws=args.laws) for job in jobs[: args.limit or taste]]
    print("\n" + tables(run_all(jobs, the_diagnosis, args.results, args.jobs)))


if __name__ == "__main__":
    main()
