"""The fixtures of the tests in a real browser."""

from tests.testbench.studio.browser.browsing import (
    browser,
    finished,
    full,
    page,
    running,
    server_without_a_traceback,
    shared,
    standing,
)

__all__ = ["browser", "finished", "full", "page", "running", "server_without_a_traceback", "shared", "standing"]
