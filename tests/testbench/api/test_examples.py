"""The example of every public function runs, and every public function has one."""

from __future__ import annotations

import doctest
import importlib
import inspect

import pytest

from gcode.support.lazy import lazy_exports

PACKAGES = ("testbench", "gcode")


def functions() -> dict[str, object]:
    """Every public function, by package and name."""
    found = {}
    for package in PACKAGES:
        module = importlib.import_module(package)
        found |= {f"{package}.{name}": getattr(module, name) for name in module.__all__}
    return {name: value for name, value in found.items() if inspect.isfunction(value)}


GIVEN = {"lazy_exports": lazy_exports}
OURS = {name: value for name, value in functions().items() if ".api" in value.__module__}


def run(name: str, told: object) -> int:
    """Run the examples in the documentation of an object; how many there were."""
    runner = doctest.DocTestRunner()
    count = 0
    for test in doctest.DocTestFinder(recurse=False).find(told, name, globs=dict(GIVEN)):
        result = runner.run(test)
        assert result.failed == 0, f"{name}: {result.failed} examples fail; see the captured output"
        count += result.attempted
    return count


@pytest.mark.parametrize("name", sorted(OURS))
def test_every_public_function_has_an_example_that_runs(name):
    if name == "gcode.read":
        pytest.skip("its example would need a file; tests/gcode reads many")
    assert run(name, OURS[name]) > 0


@pytest.mark.parametrize("name", ["gcode", "testbench", "testbench.effects", "gcode.support.lazy"])
def test_the_examples_of_a_module_run(name):
    module = importlib.import_module(name)
    told = module.lazy_exports if name == "gcode.support.lazy" else module
    assert run(name, told) > 0
