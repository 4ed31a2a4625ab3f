"""Following a growing recording: nothing lost, nothing half read, memory flat."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from testbench.studio.following import BUCKETS, RECENT_S, Envelope, Follower
from testbench.studio.pages.live import channel_of

HEADER = "time_s,displacement_mm,force_N\n"


def rows(start: int, stop: int) -> str:
    return "".join(f"{0.05 * i:.6f},{i % 7},{np.sin(i):.4f}\n" for i in range(start, stop))


def test_a_file_that_is_not_there_yet_is_waited_for(tmp_path: Path) -> None:
    follower = Follower(tmp_path / "recording.csv")
    assert not follower.look()
    assert follower.channel("time_s") is None


def test_half_a_line_waits_for_its_other_half(tmp_path: Path) -> None:
    path = tmp_path / "recording.csv"
    path.write_text(HEADER + rows(0, 10) + "0.50")
    follower = Follower(path)
    assert follower.look()
    assert len(follower.recent) == 10
    with path.open("a") as stream:
        stream.write("0000,1,0.5\n")
    assert follower.look()
    assert follower.recent[-1].tolist() == [0.5, 1.0, 0.5]
    assert not follower.look()


def test_only_the_last_minute_is_kept_in_full(tmp_path: Path) -> None:
    path = tmp_path / "recording.csv"
    path.write_text(HEADER + rows(0, 20_000))
    follower = Follower(path)
    follower.look()
    time_s = follower.channel("time_s")
    assert time_s is not None
    assert np.ptp(time_s) <= RECENT_S
    assert follower.envelope is not None
    whole, _ = follower.envelope.outline(1)
    assert whole[0] == 0.0


def test_a_channel_is_drawn_from_the_file_that_has_it(tmp_path: Path) -> None:
    (tmp_path / "compensated.csv").write_text("time_s,force_N,status\n0.00,1.5,16\n0.05,2.5,0\n")
    follower = Follower(tmp_path / "compensated.csv")
    assert channel_of(follower, "force_N", "Force (N)", 1.0, "#000000") is None
    follower.look()
    drawn = channel_of(follower, "force_N", "Force (N)", 1e3, "#000000")
    assert drawn is not None
    assert drawn.recent[1].tolist() == [1500.0, 2500.0]
    assert channel_of(follower, "displacement_mm", "Displacement (mm)", 1.0, "#000000") is None


def test_memory_is_flat_over_ten_hours() -> None:
    envelope = Envelope(2)
    block = np.column_stack([np.arange(4150) / 41.5, np.ones(4150)])
    for number in range(360):
        block[:, 0] += 100
        block[:, 1] = 1.0
        block[7, 1] = 5.0 if number == 17 else 1.0
        envelope.add(block)
    assert envelope.low.shape == (BUCKETS, 2)
    assert BUCKETS / 2 <= envelope.used <= BUCKETS
    _, values = envelope.outline(1)
    assert values.max() == 5.0, "a spike of one sample must outlive every merge"


@given(sizes=st.lists(st.integers(1, 700), min_size=1, max_size=12))
@settings(max_examples=30)
def test_the_envelope_does_not_depend_on_how_samples_arrive(sizes: list[int]) -> None:
    count = sum(sizes)
    samples = np.column_stack([np.arange(count), np.random.default_rng(count).normal(size=count)])
    whole, parts = Envelope(2), Envelope(2)
    whole.add(samples)
    for part in np.split(samples, np.cumsum(sizes)[:-1]):
        parts.add(part)
    np.testing.assert_array_equal(whole.outline(1), parts.outline(1))
    assert parts.outline(1)[1].max() == samples[:, 1].max()
    assert parts.outline(1)[1].min() == samples[:, 1].min()
