"""What all tests share: Hypothesis draws the same examples in every run; tests that share results share a process."""

from __future__ import annotations

import pytest
from hypothesis import settings

settings.register_profile("knitbench", derandomize=True, deadline=None)
settings.load_profile("knitbench")

TOGETHER = "tests/testbench/api/"  # its files share the diagnosis of one recording


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """With ``--dist loadfile`` the tests of a file run in one process, and those of one folder, too."""
    if config.getoption("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class BySharedResults(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return TOGETHER if nodeid.startswith(TOGETHER) else super()._split_scope(nodeid)

    return BySharedResults(config, log)
