"""A data set on a Dask cluster: memory, throughput beside the simulation alone, what a second run redoes.

    python benchmarks/bench_dataset.py                       40 campaigns of 23 min, two workers
    python benchmarks/bench_dataset.py --campaigns 10000

Every fourth of the data set is simulated without being written (as far as arrays of readings, and as far as the bytes
that a rig would send), then made, so that all three meet the same machine. What is compared are seconds of the
workers' processors, which others at work on the machine hardly lengthen. The workers may use 1 GB each: Dask restarts
one that needs more, and the run says so.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

from joblib import Parallel, delayed, parallel_config

from testbench.campaigns.datasets.dataset import make, run, write_index
from testbench.campaigns.datasets.spec import DatasetSpec, TrajectoryWish
from testbench.campaigns.datasets.tasks import Task, tasks_of
from testbench.rig.simulation.played import played
from testbench.rig.simulation.simulated import Motion

PARTS = 4
MEMORY_LIMIT = "1GB"


def spec_of(campaigns: int) -> DatasetSpec:
    """The paper's programs on a population of knits: each specimen plays each program once."""
    programs = min(campaigns, 4)
    specimens = -(-campaigns // programs)
    wish = TrajectoryWish(preset="paper-1", seeds=tuple(range(1, programs + 1)))
    return DatasetSpec(sensors=tuple(f"pes@{n}" for n in range(specimens)), seeds=(1,), trajectory=wish)


def simulated(task: Task) -> int:
    """The campaign without a disk: model and instruments, as far as the bytes on the wire; how many samples."""
    return sum(1 for _ in task.plan().rig(_motion(task.program, task.gauge_length_mm)).lines())


def in_arrays(task: Task) -> int:
    """Model and instruments alone, as far as arrays of readings; how many samples."""
    return len(task.plan().rig(_motion(task.program, task.gauge_length_mm)).readings().micros)


def made(task: Task) -> int:
    """The campaign on the disk, with its manifest."""
    return int(make(task))


WAYS: dict[str, Callable[[Task], int]] = {"in arrays": in_arrays, "as bytes": simulated, "made": made}


@cache
def _motion(program: Path, gauge_length_mm: float) -> Motion:
    return played(program, gauge_length_mm)[0]


def memory_MB(which: str = "VmRSS") -> float:
    """Memory of this process, now or (``VmHWM``) at its most."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(status.split(f"{which}:")[1].split()[0]) / 1024


def cpu_seconds_of(tasks: list[Task], work: Callable[[Task], int], client, workers: int) -> float:
    """Seconds of the workers' processors for these campaigns."""
    start_s = sum(client.run(time.process_time).values())
    with parallel_config(backend="dask", n_jobs=workers):
        Parallel()(delayed(work)(task) for task in tasks)
    return sum(client.run(time.process_time).values()) - start_s


def measured(tasks: list[Task], client, workers: int) -> None:
    """Make the data set part by part, and print what each took."""
    for work in (in_arrays, simulated):
        cpu_seconds_of(tasks[:workers], work, client, workers)  # compiled and imported by now
    took_s = dict.fromkeys(WAYS, 0.0)
    size = -(-len(tasks) // PARTS)
    heads = "".join(f"{f'{name} / CPU s':>18}" for name in WAYS)
    print(f"{'campaigns':>10}{heads}{'memory of the workers / MB':>30}")
    for start in range(0, len(tasks), size):
        part = tasks[start : start + size]
        for name, work in WAYS.items():
            took_s[name] += cpu_seconds_of(part, work, client, workers)
        memory = ", ".join(f"{one:.0f}" for one in sorted(client.run(memory_MB).values()))
        times = "".join(f"{seconds:>18.1f}" for seconds in took_s.values())
        print(f"{start + len(part):>10}{times}{memory:>30}", flush=True)
    most = max(client.run(memory_MB, "VmHWM").values())
    made_s = took_s.pop("made")
    ratios = ", ".join(f"{seconds / made_s:.2f} x as many as simulated {name}" for name, seconds in took_s.items())
    print(f"{len(tasks)} campaigns of 23 min: {made_s / len(tasks):.2f} s of a core each; {ratios}")
    print(f"a worker needed at most {most:.0f} MB")


def main() -> None:
    from distributed import Client, LocalCluster

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--campaigns", type=int, default=40)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("-o", dest="out", help="keep the data set here")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(args.out or folder)
        out.mkdir(parents=True, exist_ok=True)
        tasks = tasks_of(spec_of(args.campaigns), out, out)[: args.campaigns]
        cluster = LocalCluster(
            n_workers=args.workers, threads_per_worker=1, memory_limit=MEMORY_LIMIT, dashboard_address=None
        )
        with cluster, Client(cluster) as client:
            measured(tasks, client, args.workers)
            start_s = time.perf_counter()
            again, there = run(tasks, "dask", args.workers)
            took_s = time.perf_counter() - start_s
        (out / "spec.toml").write_text("# by bench_dataset\n", encoding="utf-8")
        write_index(out, out / "spec.toml", tasks)
    print(f"run again: {again} made, {there} there already, in {took_s:.1f} s")


if __name__ == "__main__":
    main()
