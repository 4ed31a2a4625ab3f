"""The intake: no wrong sample is accepted, every line is accounted for, time is the device's."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.random import default_rng

from testbench.rig.protocol.items import Bad, Event, Row, channels_of
from testbench.rig.protocol.stream import Anchor, Intake
from testbench.rig.protocol.wire import MICROS_WRAP, Sample, encode
from testbench.rig.simulation.faults import faulty

STEP_US = 24_000


def sample(number: int, boot: int = 7, micros: int | None = None, **changes) -> Sample:
    stamp = (number * STEP_US if micros is None else micros) % MICROS_WRAP
    return Sample(boot, number, stamp, 1000 + number, 400_000_000 + number, 10 * number)._replace(**changes)


def fed(intake: Intake, *samples: Sample, host_s: float = 0.0) -> list:
    return [item for one in samples for item in intake.feed(encode(one), host_s)]


def rows(items) -> list[int]:
    return [item.sample.sequence for item in items if isinstance(item, Row)]


def reasons(items) -> list[str]:
    return [item.reason for item in items if isinstance(item, Bad)]


def events(items) -> list[str]:
    return [item.kind for item in items if isinstance(item, Event)]


def test_time_starts_at_zero_and_is_the_devices():
    items = fed(Intake(), *(sample(n, micros=5_000_000 + 3 * n) for n in range(4)))
    assert [item.time_us for item in items if isinstance(item, Row)] == [0, 3, 6, 9]
    assert events(items) == ["start"]


def test_a_doubled_line_is_rejected():
    intake = Intake()
    items = fed(intake, sample(0), sample(1), sample(1), sample(2))
    assert rows(items) == [0, 1, 2]
    assert intake.bad == {"repeated": 1}


def test_a_late_line_is_rejected_and_no_longer_lost():
    intake = Intake()
    items = fed(intake, sample(0), sample(2), sample(1), sample(3))
    assert rows(items) == [0, 2, 3]
    assert (intake.lost, intake.bad) == (0, {"out of order": 1})


def test_losses_are_counted_and_located():
    intake = Intake()
    items = fed(intake, sample(0), sample(5))
    assert intake.lost == 4
    assert [item.details["lost"] for item in items if isinstance(item, Event) and item.kind == "loss"] == [4]


def test_micros_wrap_is_no_gap():
    items = fed(Intake(), *(sample(n, micros=MICROS_WRAP - 30_000 + n * STEP_US) for n in range(4)))
    assert [item.time_us for item in items if isinstance(item, Row)] == [0, 24_000, 48_000, 72_000]
    assert events(items) == ["start"]


@pytest.mark.parametrize("wraps", [0, 1, 3])
def test_a_long_silence_counts_the_wraps_by_the_hosts_clock(wraps):
    intake = Intake()
    fed(intake, sample(0), host_s=0.0)
    away_us = 1_000_000_000 + wraps * MICROS_WRAP
    # The host's clock is off by a minute; that must not matter.
    items = fed(intake, sample(1, micros=away_us), host_s=away_us / 1e6 + 60)
    assert items[-1].time_us == away_us
    assert events(items) == ["gap"]


HOUR_S = 3600


@pytest.mark.parametrize("idle_s", [0.0, 2 * HOUR_S + 30, 1.8e9])
def test_after_a_resume_the_count_of_lines_knows_the_time_where_the_hosts_clock_was_set(idle_s):
    """A computer without a battery gets its time from the network: file times may be hours or decades off."""
    intake = Intake(channels=channels_of(sample(0)))
    intake.continue_from(Anchor(7, 0, 0, host_s=-idle_s), sequence=0, interval_us=STEP_US * 1.0002)
    number = 2 * HOUR_S * 1_000_000 // STEP_US
    items = fed(intake, sample(number)._replace(displacement_nm=0), host_s=0.0)
    assert [item.time_us for item in items if isinstance(item, Row)] == [2 * HOUR_S * 1_000_000]
    assert (events(items), intake.lost) == (["gap"], number - 1)


def test_after_a_resume_the_hosts_clock_knows_the_time_of_a_device_that_waited():
    """One that sends nothing to a closed port counts nothing either."""
    intake = Intake(channels=channels_of(sample(0)))
    intake.continue_from(Anchor(7, 0, 0, host_s=-2.0 * HOUR_S), sequence=0, interval_us=STEP_US)
    items = fed(intake, sample(1, micros=2 * HOUR_S * 1_000_000), host_s=0.0)
    assert [item.time_us for item in items if isinstance(item, Row)] == [2 * HOUR_S * 1_000_000]


def test_after_a_resume_a_device_that_counts_anew_under_its_old_boot_number_is_not_years_ahead():
    intake = Intake(channels=channels_of(sample(0)))
    intake.continue_from(Anchor(7, 400 * STEP_US, 10_000_000, host_s=-13.0), sequence=400, interval_us=STEP_US)
    items = [item for n in range(60) for item in fed(intake, sample(n), host_s=n * STEP_US / 1e6)]
    times_us = [item.time_us for item in items if isinstance(item, Row)]
    assert 23_000_000 <= times_us[0] <= times_us[-1] < 26_000_000
    assert events(items) == ["reboot"]


def test_a_reboot_is_told_from_a_wrap_and_time_goes_on_by_the_host():
    intake = Intake()
    fed(intake, sample(0), sample(1), host_s=10.0)
    items = fed(intake, sample(0, boot=8, micros=100), host_s=13.5)
    items += fed(intake, sample(1, boot=8, micros=24_100), host_s=13.6)
    assert events(items) == ["reboot"]
    assert [item.time_us for item in items if isinstance(item, Row)] == [3_524_000, 3_548_000]


def test_after_a_reboot_without_a_port_the_second_line_is_no_gap():
    intake = Intake()
    fed(intake, sample(0), sample(1))
    items = [*intake.disconnected("unplugged"), *fed(intake, sample(0, boot=8), sample(1, boot=8), host_s=3.0)]
    assert events(items) == ["disconnect", "reboot"]


def test_a_line_from_before_the_reboot_is_rejected():
    intake = Intake()
    items = fed(intake, sample(0), sample(1), sample(0, boot=8), sample(2), sample(1, boot=8), host_s=1.0)
    assert reasons(items) == ["from before reboot"]
    assert rows(items) == [0, 1, 0, 1]


@pytest.mark.parametrize(("micros", "reason"), [(0, "time stands still"), (-5, "time runs backwards")])
def test_a_clock_that_does_not_run_forward_is_rejected(micros, reason):
    intake = Intake()
    fed(intake, sample(0, micros=0))
    assert reasons(fed(intake, sample(1, micros=micros % MICROS_WRAP))) == [reason]


def test_a_sample_with_other_channels_is_rejected():
    intake = Intake()
    fed(intake, sample(0))
    assert reasons(fed(intake, sample(1, temperature_mC=21_000), sample(2, force_uN=None))) == ["other channels"] * 2


def test_opening_in_the_middle_of_a_line_is_no_fault_of_the_wire():
    line = encode(sample(0))
    items = list(Intake().feed(line[30:] + encode(sample(1)), 0.0))
    assert reasons(items) == ["partial first line"]
    assert rows(items) == [1]


def test_a_line_cut_by_unplugging_is_kept_and_never_joined_to_the_next():
    intake = Intake()
    list(intake.feed(encode(sample(0)) + encode(sample(1))[:20], 0.0))
    items = list(intake.disconnected("unplugged"))
    assert reasons(items) == ["cut off"]
    assert items[-1].kind == "disconnect"
    assert rows(fed(intake, sample(2))) == [2]


def test_five_percent_of_faults_let_no_wrong_sample_through():
    sent = [sample(n) for n in range(20_000)]
    intake = Intake()
    items = [item for chunk in faulty(map(encode, sent), 0.05, default_rng(3)) for item in intake.feed(chunk, 0.0)]
    accepted = [item.sample for item in items if isinstance(item, Row)]
    assert all(one == sent[one.sequence] for one in accepted)
    assert intake.accepted == len(accepted) > 0.95 * len(sent)
    assert intake.bad == Counter(reasons(items))
    assert intake.lost + len(accepted) + intake.bad["out of order"] == accepted[-1].sequence + 1
    assert {"wrong CRC", "repeated", "out of order", "malformed"} <= set(intake.bad)


@settings(max_examples=60)
@given(st.binary(max_size=300), st.integers(1, 50))
def test_noise_from_the_line_is_rejected_and_kept(noise, cut):
    intake, kept = Intake(), b""
    for start in range(0, len(noise), cut):
        for item in intake.feed(noise[start : start + cut], 0.0):
            assert isinstance(item, Bad)
            kept += item.line
    kept += b"".join(item.line for item in intake.disconnected("x") if isinstance(item, Bad))
    assert kept == noise.replace(b"\n", b"").replace(b"\r", b"") or b"\r" in noise
    assert intake.accepted == 0
