"""Importing costs nothing, and every public name is there, for people and for type checkers."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

HEAVY = ("numpy", "pandas", "scipy", "plotly", "matplotlib", "numba", "pydantic", "sklearn")


def modules_after(code: str) -> set[str]:
    """Top-level modules that a fresh interpreter holds after `code`."""
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(*{{m.partition('.')[0] for m in sys.modules}})"],
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.split())


@pytest.mark.parametrize("package", ["testbench", "gcode", "compensation"])
def test_importing_a_package_imports_no_heavy_library(package):
    assert not modules_after(f"import {package}") & set(HEAVY)


@pytest.mark.parametrize("package", ["testbench", "gcode", "compensation"])
def test_a_package_runs_as_its_command_does(package):
    words = [sys.executable, "-m", package, "no-such-command"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith(f"{package}: error: ")


def test_the_help_of_the_command_imports_no_heavy_library():
    code = "from testbench.cli import main\ntry:\n    main(['--help'])\nexcept SystemExit:\n    pass"
    assert not modules_after(code) & set(HEAVY)


def test_the_studio_listens_before_it_imports_what_computes():
    """A thread imports that while the browser opens (`WARM` in `testbench.studio.serve`)."""
    seen = modules_after("import testbench.studio.serve, testbench.studio.shell")
    assert not seen & {"scipy", "numba", "pandas", "matplotlib", "sklearn"}


def test_a_recorder_opens_its_port_before_it_imports_what_computes():
    """It imported SciPy and numba for a bound of something else: two seconds in which nothing was recorded."""
    seen = modules_after("import testbench.api.bench.capturing, testbench.api.bench.serving")
    assert not seen & {"scipy", "numba", "pandas", "matplotlib", "sklearn"}


@pytest.mark.parametrize("package", ["testbench", "gcode", "compensation"])
def test_every_public_name_is_there(package):
    module = importlib.import_module(package)
    assert sorted(module.__all__) == dir(module)
    for name in module.__all__:
        assert getattr(module, name) is not None


@pytest.mark.parametrize("package", ["testbench", "gcode", "compensation"])
def test_type_checkers_see_what_the_running_program_has(package):
    """The imports under TYPE_CHECKING and the table `_HOMES` name the same modules and names."""
    module = importlib.import_module(package)
    tree = ast.parse(Path(module.__file__).read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    seen = {(node.module, one.name) for node in imports for one in node.names if one.name == one.asname}
    assert seen == {(home, name) for home, names in module._HOMES.items() for name in names}


@pytest.mark.parametrize("package", ["testbench", "gcode", "compensation"])
def test_a_package_says_that_it_is_typed(package):
    assert (Path(importlib.import_module(package).__file__).parent / "py.typed").is_file()


def test_a_name_that_is_not_there_is_an_attribute_error():
    import testbench as tb

    with pytest.raises(AttributeError, match="'testbench' has no attribute 'fitt'"):
        _ = tb.fitt
    with pytest.raises(AttributeError, match="`testbench effects` lists them all"):
        _ = tb.effects.StresRelaxation


def test_every_effect_of_the_catalogue_can_be_had_by_its_class():
    import testbench as tb
    from testbench.knit.catalogue import load_catalogue

    for effect in load_catalogue().effects.values():
        assert getattr(tb.effects, effect.__name__) is effect
