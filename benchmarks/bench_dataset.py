"""A data set on a Dask cluster: memory, throughput beside the simulation alone, what a second run redoes.

    python benchmarks/bench_dataset.py                       40 campaigns of 23 min, two workers
    python benchmarks/bench_dataset.py --campaigns 10000     the size that docs/datasets.md speaks of

Every fourth of the data set is simulated without being written, then made, so that both meet the same machine. The
workers may use 1 GB each: Dask restarts one that needs more, and the run says so.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from functools import cache
from pathlib import Path

from joblib import Parallel, delayed, parallel_config

from testbench.campaigns.dataset import Task, run, tasks_of, write_index
from testbench.campaigns.dataset_spec import DatasetSpec, TrajectoryWish
from testbench.rig.motion import played
from testbench.rig.simulated import Motion

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


@cache
def _motion(program: Path, gauge_length_mm: float) -> Motion:
    return played(program, gauge_length_mm)[0]


def memory_MB(which: str = "VmRSS") -> float:
    """Memory of this process, now or (``VmHWM``) at its most."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(status.split(f"{which}:")[1].split()[0]) / 1024


def seconds_of(tasks: list[Task], made: bool, workers: int) -> float:
    """Seconds for these campaigns on the cluster that is active."""
    start_s = time.perf_counter()
    if made:
        run(tasks, "dask", workers)
    else:
        with parallel_config(backend="dask", n_jobs=workers):
            Parallel()(delayed(simulated)(task) for task in tasks)
    return time.perf_counter() - start_s


def measured(tasks: list[Task], client, workers: int) -> None:
    """Make the data set part by part, and print what each took."""
    warm = tasks[:workers]
    seconds_of(warm, False, workers)  # compiled and imported by now
    alone_s = made_s = 0.0
    size = -(-len(tasks) // PARTS)
    print(f"{'campaigns':>10}{'alone / s':>12}{'made / s':>12}{'ratio':>8}{'memory of the workers / MB':>30}")
    for start in range(0, len(tasks), size):
        part = tasks[start : start + size]
        alone_s += seconds_of(part, False, workers)
        made_s += seconds_of(part, True, workers)
        memory = ", ".join(f"{one:.0f}" for one in sorted(client.run(memory_MB).values()))
        ratio = alone_s / made_s
        print(f"{start + len(part):>10}{alone_s:>12.1f}{made_s:>12.1f}{ratio:>8.2f}{memory:>30}", flush=True)
    most = max(client.run(memory_MB, "VmHWM").values())
    each_s, ratio = made_s / len(tasks), alone_s / made_s
    print(f"{len(tasks)} campaigns of 23 min: {each_s:.2f} s each, {ratio:.2f} x as many as simulated alone")
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
            made, there = run(tasks, "dask", args.workers)
            took_s = time.perf_counter() - start_s
        (out / "spec.toml").write_text("# by bench_dataset\n", encoding="utf-8")
        write_index(out, out / "spec.toml", tasks)
    print(f"run again: {made} made, {there} there already, in {took_s:.1f} s")


if __name__ == "__main__":
    main()
