"""The example of every public function runs, and every public function has one."""

from __future__ import annotations

import importlib
import inspect

import pytest

from tests.testbench.api.samples import after_examples

PACKAGES = ("testbench", "gcode", "compensation")
GIVEN = ("Result", "Case", "Experiment", "Ladder", "Made", "Program", "Trajectory", "UserError")  # nobody makes these
ELSEWHERE = {"testbench.Effect", "testbench.Stage"}  # in the example of `parameter`


def told() -> dict[str, object]:
    """Every public function, and every public class that people make themselves, by package and name."""
    found = {}
    for package in PACKAGES:
        module = importlib.import_module(package)
        found |= {f"{package}.{name}": getattr(module, name) for name in module.__all__}
    return {
        name: value
        for name, value in found.items()
        if inspect.isroutine(value) or (inspect.isclass(value) and not name.endswith(GIVEN))
    }


OURS = told()
LONG = {"testbench.investigate"}  # minutes of diagnosis


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in sorted(OURS.keys() - ELSEWHERE)]
)
def test_what_is_public_has_an_example_that_runs(name):
    assert after_examples(name, OURS[name])


@pytest.mark.parametrize("name", ["gcode", "testbench", "testbench.effects", "gcode.support.lazy"])
def test_the_examples_of_a_module_run(name):
    module = importlib.import_module(name)
    told = module.lazy_exports if name == "gcode.support.lazy" else module
    assert after_examples(name, told)
