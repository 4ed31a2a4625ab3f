"""A sweep whose process, worker or cluster node is killed: nothing that was done is lost."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from compensation.search import search, search_space
from gcode.support.errors import UserError
from tests.compensation.search.tasks import task_of

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def task(recordings, tmp_path_factory):
    return task_of(recordings, 120, tmp_path_factory.mktemp("search"))


JOBS = [(candidate, seed) for seed in range(2) for candidate in search_space.candidates()[::40]]


@pytest.fixture(scope="module")
def undisturbed(task, tmp_path_factory):
    """The rows of a sweep that nobody disturbed."""
    return ordered(search.sweep(task, JOBS, tmp_path_factory.mktemp("u") / "s.jsonl", workers=1))


def ordered(rows):
    """By their keys, in twelve digits: how sums are rounded depends on where in memory their terms lie."""
    rounded = [{key: float(f"{x:.12g}") if isinstance(x, float) else x for key, x in row.items()} for row in rows]
    return sorted(rounded, key=json.dumps)


def test_the_whole_program_is_killed_and_goes_on(task, undisturbed, tmp_path):
    results = tmp_path / "s.jsonl"
    script = (
        "import sys; from compensation.search import search; "
        "from tests.compensation.search.test_search_killed import JOBS; "
        f"search.sweep(search.Task({task.recordings!r}, 25.0, 'force', 'fast'), JOBS, sys.argv[1], workers=2)"
    )
    root = Path(__file__).resolve().parents[3]
    with subprocess.Popen([sys.executable, "-c", script, results], cwd=root, start_new_session=True) as sweep:
        while sweep.poll() is None and (not results.exists() or results.read_text().count("\n") < 6):
            time.sleep(0.02)
        os.killpg(sweep.pid, signal.SIGKILL)
    done = results.read_text().count("\n") - 1
    assert 5 <= done < len(JOBS)
    again = []
    assert ordered(search.sweep(task, JOBS, results, workers=1, progress=again.append)) == undisturbed
    assert len(again) == len(JOBS) - done


def test_a_killed_worker_process_ends_the_sweep_with_a_sentence(task, undisturbed, tmp_path):
    from joblib.externals.loky import get_reusable_executor

    def kill_one(note, killed=[]):  # noqa: B006
        if not killed:
            killed.append(next(iter(get_reusable_executor(reuse=True)._processes)))
            os.kill(killed[0], signal.SIGKILL)

    results = tmp_path / "s.jsonl"
    with pytest.raises(UserError, match="worker process was killed"):
        search.sweep(task, JOBS, results, workers=2, progress=kill_one)
    assert ordered(search.sweep(task, JOBS, results, workers=1)) == undisturbed


@pytest.mark.filterwarnings("ignore")
def test_a_killed_node_of_a_cluster_does_not_matter(task, undisturbed, tmp_path, monkeypatch):
    """Killed while it works on the second round; the cluster starts another, and every row is there."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(search, "DASK_ROUND", 16)
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        first, timers = cluster.workers[0].pid, []

        def kill_one(note):
            if not timers:
                timers.append(threading.Timer(0.2, os.kill, (first, signal.SIGKILL)))
                timers[0].start()

        address = cluster.scheduler_address
        rows = search.sweep(task, JOBS, tmp_path / "s.jsonl", backend="dask", scheduler=address, progress=kill_one)
        timers[0].join()
    with pytest.raises(ProcessLookupError):
        os.kill(first, 0)
    assert ordered(rows) == undisturbed
