"""The ESP32 sketch on a PC: its lines are what the stream gives, and the header does no more than it says."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compensation.export.export_c import c_header, cost
from compensation.memories.history import History
from compensation.model.compensator import Scaling
from compensation.model.runtime import Status
from compensation.model.streaming import CompensatorStream
from compensation.training.options import Options
from tests.compensation.conftest import train

SHIM = Path(__file__).parent / "arduino"
SKETCH = Path(__file__).parents[3] / "firmware" / "knitbench_compensator"
REFERENCE_OHM, SUPPLY_V, LSB_V, CONVERSIONS_A_SAMPLE = 606e3, 3.3, 125e-6, 6.4


@pytest.fixture(scope="module")
def compensator(recordings):
    history = History((0.1, 2.0, 8.0), (0.2, 0.5), 0.05)
    return train(recordings[:1], "force", Options(sizes=(6, 3), restarts=1, history=history, engine="fast"))


def built(folder: Path, source: str, compensator, *more: str) -> Path:
    if shutil.which("g++") is None:
        pytest.skip("g++ is not installed")
    (folder / "knit.h").write_text(c_header(compensator, "knit"))
    flags = ["-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", f"-I{folder}", f"-I{SHIM}", f"-I{SKETCH}", *more]
    subprocess.run(["g++", *flags, str(SHIM / source), "-o", str(folder / "program")], check=True, timeout=120)
    return folder / "program"


def codes(conductance_S: np.ndarray) -> np.ndarray:
    """What the converter reads, some six times a sample."""
    repeated = np.repeat(conductance_S, int(CONVERSIONS_A_SAMPLE))
    share = repeated * REFERENCE_OHM
    return np.rint(SUPPLY_V * share / (1 + share) / LSB_V).astype(int)


def test_the_sketch_says_what_the_stream_says(compensator, recordings, tmp_path):
    program = built(tmp_path, "run_sketch.cpp", compensator)
    read = codes(np.interp(np.arange(0, 60, 0.05), recordings[1].time_s, recordings[1].conductance_S))
    read[1000:1100] = 0  # a lead falls off
    text = "\n".join(map(str, read))
    out = subprocess.run([program], input=text, capture_output=True, check=True, text=True, timeout=60).stdout
    lines = np.array([[float(part) for part in line.split(",")] for line in out.splitlines()])
    assert len(lines) == pytest.approx(len(read) / CONVERSIONS_A_SAMPLE, rel=0.02)
    assert np.isclose(lines[0, 1], recordings[1].conductance_S[0], rtol=0.01)  # no conversion that never was
    stream, last_us, off = CompensatorStream(compensator), None, 0
    for time_us, conductance_S, value, status, _ in lines:
        step_s = 0.05 if last_us is None else ((time_us - last_us) % 2**32) * 1e-6
        expected = stream.update(conductance_S, step_s)
        assert value == pytest.approx(expected, abs=2e-4 * compensator.scaling_out.scale)
        assert Status(int(status)) & Status.BAD_READING == stream.status & Status.BAD_READING
        off += bool(stream.status & Status.BAD_READING)
        if not stream.status & (Status.BAD_READING | Status.BAD_STEP):
            last_us = time_us
    assert 10 < off < 20  # 100 of the conversions, 6.4 a sample


@pytest.mark.parametrize("mean", [-3e38, 3e38, -1e30])
def test_a_line_of_any_value_is_whole(compensator, recordings, tmp_path, mean):
    far = replace(compensator, scaling_out=Scaling(mean, 1.0))
    program = built(tmp_path, "run_sketch.cpp", far, "-fsanitize=address,undefined", "-fno-sanitize-recover")
    text = "\n".join(map(str, codes(recordings[1].conductance_S[:20])))
    out = subprocess.run([program], input=text, capture_output=True, check=True, text=True, timeout=60).stdout
    lines = [line.split(",") for line in out.splitlines()]
    assert len(lines) > 10
    assert {len(line) for line in lines} == {5}
    assert all(float(line[2]) == pytest.approx(mean, rel=1e-6) for line in lines)


@pytest.mark.parametrize("step_s", ["0.05", "0.0502"])
def test_the_header_multiplies_as_often_as_it_says(compensator, recordings, tmp_path, step_s):
    """The sketch hardly ever has a step of exactly 1 / rate."""
    program = built(tmp_path, "count_operations.cpp", compensator)
    samples = "\n".join(map(str, recordings[1].conductance_S[:200]))
    out = subprocess.run(
        [program, step_s], input=samples, capture_output=True, check=True, text=True, timeout=60
    ).stdout
    multiplied, added, divided, _ = map(int, out.split())
    needs = cost(compensator)
    said = needs.multiplies if step_s == "0.05" else needs.multiplies_any_step
    assert multiplied == pytest.approx(said, abs=0.1 * said)
    assert added < 1.6 * said
    assert divided <= 1  # the speed
