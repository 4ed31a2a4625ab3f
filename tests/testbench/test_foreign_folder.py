"""A command that is started in a stranger's folder runs nothing that lies there."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from gcode.support.console import KEPT_OUT
from testbench.knit.catalogue import baseline
from testbench.results.model_file import ModelFile
from tests.testbench.rig.rigs import program

MODULES = ("numpy", "pandas", "joblib", "cloudpickle", "pydantic", "gcode", "testbench", "argparse", "json")
MINE = "import pathlib; pathlib.Path(__file__).with_name('it-ran').write_text(__name__)\n"
# As the console script, whose own folder Python looks into: -P holds for this process alone.
START = "from testbench.cli import main; code = main({words}); {then}; raise SystemExit(code)"
JOB = (
    "import subprocess; from testbench.studio.jobs.jobs import interpreter_argv; "
    "code = subprocess.run(interpreter_argv(['testbench', 'effects'])).returncode"
)


@pytest.fixture
def foreign(tmp_path) -> Path:
    """A folder with a data set's spec, and modules and settings that nobody asked for."""
    program(tmp_path)
    ModelFile(baseline(), 25.0).save(tmp_path / "knit.json")
    spec = 'sensors = ["knit.json"]\nseeds = "1-2"\nprograms = ["two_*.tap"]\ngauge_length_mm = 25\n'
    (tmp_path / "set.toml").write_text(spec)
    for name in MODULES:
        (tmp_path / f"{name}.py").write_text(MINE)
    (tmp_path / ".numba_config.yaml").write_text("cache_dir: cache\n")
    return tmp_path


@pytest.mark.parametrize(
    ("words", "then"),
    [
        (["dataset", "set.toml", "-o", "out", "--workers", "2"], "pass"),
        (["effects"], JOB),
    ],
    ids=["workers", "a job of the studio"],
)
def test_nothing_of_the_folder_runs(foreign, words, then):
    environment = {name: value for name, value in os.environ.items() if name not in KEPT_OUT}
    code = START.format(words=words, then=then)
    done = subprocess.run(
        [sys.executable, "-P", "-c", code], cwd=foreign, env=environment, capture_output=True, text=True, check=False
    )
    assert not (foreign / "it-ran").exists()
    assert not (foreign / "cache").exists()
    assert done.returncode == 0, done.stderr
