"""Programs as read by readers nobody here wrote: LinuxCNC's interpreter and a parser from PyPI."""

from __future__ import annotations

import re
import shutil
import subprocess

import numpy as np
import pytest
from gcodeparser import parse_gcode_lines

from gcode.mach4.reader import parse_program
from gcode.programs.make import make
from gcode.trajectories.designed import Hold, Multisine, Noise, Ramp, RateSweep, ReturnToZero, Staircase, Triangle
from gcode.trajectories.presets import PRESETS, preset
from gcode.trajectories.trajectory import TrajectorySpec

PROTOCOLS = {
    "designed": Hold(duration_s=1)
    + Triangle(high_percent=20, speed_mm_per_s=2, cycles=2, rest_s=0.5)
    + Staircase(levels_percent=(5, 10, 5), speed_mm_per_s=1, hold_s=1.5)
    + RateSweep(high_percent=10, speeds_mm_per_s=(0.5, 2.0))
    + ReturnToZero(rest_s=2),
    "mixed": Ramp(to_percent=10, speed_mm_per_s=0.02)
    + Multisine(duration_s=10, frequencies_hz=(0.1, 0.23))
    + Noise(duration_s=20),
}


def program_of(name: str, mode: str) -> tuple[str, np.ndarray]:
    if name in PRESETS:
        noise = preset(name).pieces[0].model_copy(update={"duration_s": 120.0, "target": None})
        spec = preset(name).model_copy(update={"pieces": (noise,)})
    else:
        spec = TrajectorySpec.of(PROTOCOLS[name], name=name)
    made = make(spec, 51, 25.0, mode)
    return made.program, made.trajectory.position_mm


every_kind = pytest.mark.parametrize("mode", ["G94", "G93"])
every_name = pytest.mark.parametrize("name", [*PRESETS, *PROTOCOLS])


@pytest.mark.linuxcnc
@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 is not installed (Debian: linuxcnc-uspace)")
@every_kind
@every_name
def test_linuxcnc_reads_every_move(name, mode, tmp_path):
    text, planned = program_of(name, mode)
    path = tmp_path / "program.ngc"
    path.write_text(text, encoding="ascii")
    done = subprocess.run(["rs274", "-g", str(path)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    feeds = re.findall(r"STRAIGHT_FEED\((-?[\d.]+),", done.stdout)
    assert len(feeds) == text.count("\nG1 ")
    assert max(float(x) for x in feeds) == pytest.approx(planned.max(), abs=6e-5)
    assert float(feeds[-1]) == 0.0
    assert done.stdout.count("DWELL(") == text.count("\nG4 ")


@pytest.mark.linuxcnc
@pytest.mark.skipif(shutil.which("rs274") is None, reason="rs274 is not installed (Debian: linuxcnc-uspace)")
@pytest.mark.parametrize("fault", ["G1 X1", "G1 X1 F0", "G1 X1E-1 F6", "G1 XNAN F6", "(open", "G0 G1 X1 F6"])
def test_what_linuxcnc_refuses_we_refuse(fault, tmp_path):
    text = f"G21 G90 G94\n{fault}\nG1 X2 F60\nM30\n"
    path = tmp_path / "fault.ngc"
    path.write_text(text, encoding="ascii")
    done = subprocess.run(["rs274", "-g", str(path)], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode != 0
    assert parse_program(text).problems


@every_kind
@every_name
def test_a_parser_from_pypi_reads_the_same_positions_and_feeds(name, mode):
    text, planned = program_of(name, mode)
    lines = list(parse_gcode_lines(text))
    moves = [line for line in lines if line.command == ("G", 1)]
    assert len(moves) == text.count("\nG1 ")
    assert all(line.params["F"] > 0 for line in moves)
    positions = np.array([line.params["X"] for line in moves])
    turning = planned[np.flatnonzero(np.diff(planned)) + 1]
    np.testing.assert_allclose(positions, turning, atol=1e-9)
