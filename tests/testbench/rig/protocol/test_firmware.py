"""The reference firmware on a PC: its lines are the Python encoder's byte for byte, its loop makes a recording."""

from __future__ import annotations

import random
import shutil
import subprocess
from pathlib import Path

import pytest

from testbench.rig.protocol.items import Row
from testbench.rig.protocol.stream import Intake
from testbench.rig.protocol.wire import MICROS_WRAP, Sample, encode
from tests.testbench.rig.devices import PATIENCE_S

HERE = Path(__file__).parent / "arduino"
FIRMWARE = Path(__file__).parents[4] / "firmware" / "knitbench_rig"
EXTREMES = [
    Sample(0, 0, 0, 0, 0, 0, 0),
    Sample(2**32 - 1, 2**32 - 1, 2**32 - 1, -(2**31), 10**15 - 1, -(2**31), -9_999_999),
    Sample(1, 2, 3, 2**31 - 1, 4, 2**31 - 1, 9_999_999),
    Sample(1, 2, 3, None, 4, 5),
    Sample(1, 2, 3, 4, None, 5),
]


def built(tmp_path: Path, source: str, compiler: str, *flags: str) -> Path:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    program = tmp_path / "program"
    words = [compiler, *flags, "-Wall", "-Wextra", "-Werror", f"-I{FIRMWARE}", f"-I{HERE}", str(HERE / source)]
    subprocess.run([*words, "-o", str(program)], check=True, timeout=PATIENCE_S)
    return program


def some_samples(count: int) -> list[Sample]:
    chance = random.Random(11)

    def number(low: int, high: int) -> int:
        return chance.randint(low, high) >> chance.randrange(0, 28)

    return [
        Sample(
            number(0, 2**32 - 1),
            number(0, 2**32 - 1),
            number(0, 2**32 - 1),
            number(-(2**31), 2**31 - 1),
            number(0, 10**15 - 1),
            number(-(2**31), 2**31 - 1),
            number(-9_999_999, 9_999_999),
        )
        for _ in range(count)
    ]


def numbers_of(sample: Sample) -> str:
    """A sample as the C program reads it: each optional channel as a flag and a value."""
    parts = [sample.boot, sample.sequence, sample.micros]
    for value in (sample.force_uN, sample.resistance_mohm):
        parts += [int(value is not None), value or 0]
    temperature = sample.temperature_mC
    return " ".join(map(str, [*parts, sample.displacement_nm, int(temperature is not None), temperature or 0]))


def test_the_formatter_in_c_writes_what_the_encoder_in_python_writes(tmp_path):
    program = built(tmp_path, "format_lines.c", "gcc", "-std=c99")
    samples = EXTREMES + some_samples(2000)
    text = "\n".join(map(numbers_of, samples)) + "\n"
    out = subprocess.run([program], input=text.encode(), capture_output=True, check=True, timeout=PATIENCE_S).stdout
    assert out.splitlines(keepends=True) == [encode(sample) for sample in samples]


def test_the_longest_line_fits_its_buffer():
    (limit,) = [
        line.split()[2] for line in (FIRMWARE / "kb_line.h").read_text().splitlines() if "define KB_LINE_MAX" in line
    ]
    longest = Sample(2**32 - 1, 2**32 - 1, 2**32 - 1, -(2**31), 10**15 - 1, -(2**31), -(2**31))
    assert len(encode(longest)) <= int(limit)


@pytest.fixture
def sketch(tmp_path):
    return built(tmp_path, "run_sketch.cpp", "g++", "-std=c++17")


def rows_of(*command: str | Path) -> list[Row]:
    out = subprocess.run(command, capture_output=True, check=True, timeout=PATIENCE_S).stdout
    intake = Intake()
    rows = [item for item in intake.feed(out, 0.0) if isinstance(item, Row)]
    assert (intake.accepted, intake.lost, intake.bad.total()) == (len(rows), 0, 0)
    return rows


def test_the_first_line_waits_for_both_chips(sketch):
    first, *_, last = rows_of(sketch)
    assert first.sample.force_uN == last.sample.force_uN
    assert first.sample.resistance_mohm == last.sample.resistance_mohm


def test_a_load_cell_that_stops_is_no_force_that_stands_still(sketch):
    whole, cut = rows_of(sketch), rows_of(sketch, "stop")
    assert 0.5 * len(whole) < len(cut) < 0.7 * len(whole)
    assert [row.sample.force_uN for row in cut] == [row.sample.force_uN for row in whole[: len(cut)]]


def test_the_whole_sketch_runs_and_its_lines_are_a_recording(sketch):
    rows = rows_of(sketch)
    assert rows[0].sample.boot == 0x5F3A9C01
    assert rows[0].sample.micros > rows[-1].sample.micros  # the clock wrapped, time did not
    assert rows[-1].time_us > MICROS_WRAP - 4_294_000_000
    rate_hz = (len(rows) - 1) / rows[-1].time_us * 1e6
    assert rate_hz == pytest.approx(41.5, rel=0.02)
    # -123456 codes of 2.33 nV over 0.102 mV/N; half the supply across the reference; steps of 1.25 um.
    assert rows[-1].sample.force_uN == pytest.approx(-123456 * 22.833, rel=1e-3)
    assert rows[-1].sample.resistance_mohm == pytest.approx(606e6, rel=1e-6)
    assert rows[-1].sample.displacement_nm % 1250 == 0
    assert rows[-1].sample.displacement_nm > rows[0].sample.displacement_nm
