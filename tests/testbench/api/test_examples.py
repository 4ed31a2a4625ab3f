"""The example of every public function runs, and every public function has one."""

from __future__ import annotations

import importlib
import inspect

import pytest

from tests.testbench.api.samples import after_examples

PACKAGES = ("testbench", "gcode")


def functions() -> dict[str, object]:
    """Every public function, by package and name."""
    found = {}
    for package in PACKAGES:
        module = importlib.import_module(package)
        found |= {f"{package}.{name}": getattr(module, name) for name in module.__all__}
    return {name: value for name, value in found.items() if inspect.isfunction(value)}


OURS = {name: value for name, value in functions().items() if ".api" in value.__module__}


@pytest.mark.parametrize("name", sorted(OURS))
def test_every_public_function_has_an_example_that_runs(name):
    if name == "gcode.read":
        pytest.skip("its example would need a file; tests/gcode reads many")
    assert after_examples(name, OURS[name])


@pytest.mark.parametrize("name", ["gcode", "testbench", "testbench.effects", "gcode.support.lazy"])
def test_the_examples_of_a_module_run(name):
    module = importlib.import_module(name)
    told = module.lazy_exports if name == "gcode.support.lazy" else module
    assert after_examples(name, told)
