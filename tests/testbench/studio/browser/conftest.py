"""The fixtures of the tests in a real browser."""

from tests.testbench.studio.browser.browsing import browser, finished, full, page, running, shared, standing

__all__ = ["browser", "finished", "full", "page", "running", "shared", "standing"]
