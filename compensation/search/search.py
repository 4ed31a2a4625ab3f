"""The sweep over candidates (`compensation.search.search_space`), each from several seeds."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from compensation.engines.engine import DEFAULT_L2, ENGINES
from compensation.memories.ema import PAPER_RATE_HZ
from compensation.search.search_space import Candidate
from compensation.series.preprocessing import Series, apart, series_of
from compensation.series.reading import check_tared, read_signals
from compensation.series.score import error_of_two, r2
from compensation.training.options import Options
from compensation.training.untrained import training_arrays, untrained
from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from gcode.support.files import write_text
from gcode.support.strict import json_of, read_text

DASK_ROUND = 50
RANKED_BY = ("seed", "parameters", "dead", "E", "r2_A", "r2_B")


@dataclass(frozen=True)
class Task:
    """What all jobs of one sweep share; paths, not data, so that any worker can load it."""

    recordings: tuple[str, ...]
    gauge_length_mm: float | None
    target: str
    engine: str
    per_recording: bool = False


def evaluate(task: Task, candidate: Candidate, seed: int) -> dict[str, Any]:
    """Train one candidate from one seed on the first recording, score it on the other two."""
    (features, truth), *tests = _arrays(task, candidate.alphas)
    network = ENGINES[task.engine](features, truth, candidate.sizes, seed, DEFAULT_L2).network
    scores = [r2(target, network(inputs)) for inputs, target in tests]
    return {
        "key": candidate.key,
        "seed": seed,
        "alphas": list(candidate.alphas),
        "sizes": list(candidate.sizes),
        "parameters": network.parameter_count,
        "dead": network.is_dead(features),
        "training_r2": r2(truth, network(features)),
        "r2_A": scores[0],
        "r2_B": scores[1],
        "E": error_of_two(*scores),
    }


def check(task: Task) -> None:
    """Read the recordings once, so that a bad one, or one twice, is refused before anything is started."""
    _series(task)


@lru_cache(maxsize=2)
def _series(task: Task) -> list[Series]:
    recordings = [read_signals(path, task.gauge_length_mm) for path in task.recordings]
    for recording in recordings:
        check_tared(recording, task.target)
    series = [series_of(recording, task.target, PAPER_RATE_HZ) for recording in recordings]
    return apart(series, "training, A and B are three recordings; give each once")


@lru_cache(maxsize=8)
def _arrays(task: Task, alphas: tuple[float, ...]) -> list[tuple[FloatArray, FloatArray]]:
    """Features and standardised target of training, A and B."""
    series = _series(task)
    blank = untrained(series[:1], task.target, Options(alphas=alphas, per_recording=task.per_recording))
    return [training_arrays(blank, [part]) for part in series]


def sweep(
    task: Task,
    jobs: Sequence[tuple[Candidate, int]],
    results: str | Path,
    workers: int = 2,
    backend: str = "loky",
    scheduler: str | None = None,
    progress: Callable[[str], None] = lambda note: None,
) -> list[dict[str, Any]]:
    """Run every job that `results` does not hold yet; each is appended as soon as it is done.

    `results` are JSON lines: a sweep that was killed goes on from there. `workers` processes run on this machine
    (backend ``loky``), or on a Dask cluster: that of the `scheduler`, or a local one.

    Raises
    ------
    UserError
        If `results` belongs to another sweep, if only by what its recordings hold, or a worker process was killed.
    """
    done = _open_results(Path(results), task)
    known = {(row["key"], row["seed"]) for row in done}
    missing = [(candidate, seed) for candidate, seed in jobs if (candidate.key, seed) not in known]
    wanted = {(candidate.key, seed) for candidate, seed in jobs}
    with Path(results).open("a", encoding="utf-8") as stream:
        for row in _run(task, missing, workers, backend, scheduler):
            stream.write(json.dumps(row) + "\n")
            stream.flush()
            done.append(row)
            progress(f"{row['key']}: E {row['E']:.4f}")
    once = {(row["key"], row["seed"]): row for row in done}  # two sweeps at a time may have written both
    return [row for job, row in once.items() if job in wanted]


def _run(
    task: Task, jobs: Sequence[tuple[Candidate, int]], workers: int, backend: str, scheduler: str | None
) -> Iterator[dict[str, Any]]:
    from concurrent.futures.process import BrokenProcessPool

    from joblib import Parallel, delayed

    if backend == "dask":
        yield from _on_cluster(task, jobs, workers, scheduler)
        return
    calls = (delayed(evaluate)(task, candidate, seed) for candidate, seed in jobs)
    try:
        yield from Parallel(n_jobs=workers, return_as="generator_unordered")(calls)
    except BrokenProcessPool:
        raise UserError(
            "a worker process was killed (out of memory?); what was done is kept: run the search again to go on"
        ) from None


def _on_cluster(
    task: Task, jobs: Sequence[tuple[Candidate, int]], workers: int, scheduler: str | None
) -> Iterator[dict[str, Any]]:
    from joblib import Parallel, delayed, parallel_config

    try:
        from distributed import Client
    except ImportError:
        raise UserError("--backend dask needs dask: pip install 'knitbench[dask]'") from None
    calls = [delayed(evaluate)(task, candidate, seed) for candidate, seed in jobs]
    try:
        client = Client(scheduler) if scheduler else Client(n_workers=workers, threads_per_worker=1)
    except (OSError, ValueError) as error:
        where = f"--scheduler {scheduler}: no Dask scheduler answers there" if scheduler else "--backend dask"
        raise UserError(f"{where} ({error})") from None
    with client:
        # joblib's Dask backend returns lists only: go in rounds, so that a kill costs one round.
        for begin in range(0, len(calls), DASK_ROUND):
            with parallel_config(backend="dask"):
                yield from Parallel()(calls[begin : begin + DASK_ROUND])


def _open_results(path: Path, task: Task) -> list[dict[str, Any]]:
    """Rows so far; a new file gets a first line that says what it is about."""
    task_said, content = json.loads(json.dumps(asdict(task))), [part.digest for part in _series(task)]
    header = {"format": "knitbench-search", "version": 3, "task": task_said, "recordings_sha256": content}
    if not path.exists():
        write_text(path, json.dumps(header) + "\n")
        return []
    try:
        text = read_text(path, "search")
        whole = text[: text.rfind("\n") + 1]
        first, *rows = [json_of(line, "search") for line in whole.splitlines()]
    except ValueError:
        raise UserError(f"{path}: not a search of knitbench; choose another file") from None
    if first != header:
        raise UserError(f"{path}: holds a search of other recordings, target or engine; choose another file")
    for line, row in enumerate(rows, start=2):
        if not _is_result(row):
            raise UserError(
                f"{path}: line {line} is not a result of a search; take the line out, or give another file"
            )
    if whole != text:
        # A kill in the middle of a line: that job is done again.
        write_text(path, whole)
    return rows


def _is_result(row: Any) -> bool:
    """Whether a line holds what the ranking needs."""
    if not isinstance(row, dict) or not isinstance(row.get("key"), str):
        return False
    return all(isinstance(row.get(name), int | float) for name in RANKED_BY)
