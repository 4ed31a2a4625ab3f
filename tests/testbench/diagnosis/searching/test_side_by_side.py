"""What runs side by side comes back whole, in order, and fails as it would alone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import types

import numpy as np
import pytest

from testbench.diagnosis.searching.side_by_side import SideBySide


@pytest.fixture(params=["processes", "threads", "alone"])
def pool(request: pytest.FixtureRequest) -> SideBySide:
    made = SideBySide()
    made.count = 1 if request.param == "alone" else 2
    made.forks = made.forks and request.param == "processes"
    return made


def test_results_come_in_the_order_of_the_arguments(pool: SideBySide) -> None:
    factor = np.arange(3.0)
    results = list(pool.map(lambda a, b: a * factor + b, range(7), range(10, 17)))
    np.testing.assert_array_equal(results, [a * factor + b for a, b in zip(range(7), range(10, 17), strict=True)])


def test_an_error_is_raised_where_the_results_are_asked_for(pool: SideBySide) -> None:
    with pytest.raises(ZeroDivisionError, match="division by zero"):
        pool.map(lambda x: 1 / x, [1, 0, 2])


def test_nothing_to_do_gives_nothing(pool: SideBySide) -> None:
    assert list(pool.map(str, [])) == []


@pytest.mark.skipif(sys.platform != "linux", reason="forks on Linux alone")
def test_the_work_is_done_in_other_processes() -> None:
    pool = SideBySide()
    pool.count = 2
    assert os.getpid() not in list(pool.map(lambda _: os.getpid(), range(4)))


KILLED_AT_WORK = """
import os, signal, sys
from testbench.diagnosis.searching.side_by_side import SideBySide

def work(number):
    if number == 1:
        print(os.getpid(), flush=True)
        os.kill(os.getppid(), signal.SIGKILL)
    signal.pause()

pool = SideBySide()
pool.count = 2
pool.map(work, range(2))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="forks on Linux alone")
def test_nothing_outlives_a_parent_that_was_killed() -> None:
    # What it writes to ends only as the last process that could still write has ended.
    killed = subprocess.run([sys.executable, "-c", KILLED_AT_WORK], capture_output=True, timeout=60, check=False)
    assert killed.returncode == -signal.SIGKILL
    assert int(killed.stdout) > 0


def test_classes_of_a_users_file_are_not_sent() -> None:
    module = types.ModuleType("knitbench_user_mine")
    exec("class Mine: pass", module.__dict__)
    assert not SideBySide([module.__dict__["Mine"]]).forks


def test_classes_made_in_a_function_are_not_sent() -> None:
    class Mine:
        pass

    assert not SideBySide([Mine]).forks
