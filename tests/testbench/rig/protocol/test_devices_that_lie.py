"""Devices that lie about their clock, lose their count or say nothing: bounded, recorded, and said to the person."""

from __future__ import annotations

import json
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.random import default_rng

from testbench.rig.acquisition.recorder import Recorder
from testbench.rig.acquisition.sink import Sink
from testbench.rig.acquisition.watchdog import Watchdog
from testbench.rig.connection.parts import Chunk, End, Tick
from testbench.rig.protocol.items import Row, channels_of
from testbench.rig.protocol.stream import Anchor, Intake
from testbench.rig.protocol.wire import MICROS_WRAP, SEQUENCE_WRAP, Sample, encode
from tests.testbench.rig.protocol import test_stream
from tests.testbench.rig.protocol.test_stream import STEP_US, events, fed, reasons, rows

MINUTE_US = 60_000_000


def sample(number: int, **changes):
    """A sample whose readings fit the wire whatever its number is."""
    return test_stream.sample(number, **changes)._replace(force_uN=number % 1000, displacement_nm=number % 1000)


def line_of_time(intake: Intake, count: int, start: int = 0, offset_us: int = 0, number_offset: int = 0) -> list:
    """`count` samples at their host times, with a clock and a count that are off."""
    items = []
    for n in range(start, start + count):
        one = sample((n + number_offset) % SEQUENCE_WRAP, micros=(n * STEP_US + offset_us) % MICROS_WRAP)
        items += fed(intake, one, host_s=n * STEP_US / 1e6)
    return items


def times_us(items) -> list[int]:
    return [item.time_us for item in items if isinstance(item, Row)]


def test_the_wrap_of_the_sequence_number_is_no_fault():
    intake = Intake()
    items = line_of_time(intake, 50, number_offset=SEQUENCE_WRAP - 20)
    assert len(rows(items)) == 50
    assert (intake.lost, dict(intake.bad)) == (0, {})
    assert events(items) == ["start"]


def test_losses_across_the_wrap_are_counted_once():
    intake = Intake()
    fed(intake, sample(SEQUENCE_WRAP - 3, micros=0))
    fed(intake, sample(2, micros=3 * STEP_US), host_s=0.1)
    assert intake.lost == 4
    assert reasons(fed(intake, sample(SEQUENCE_WRAP - 1, micros=STEP_US), host_s=0.1)) == ["out of order"]
    assert intake.lost == 3


def test_a_number_beyond_32_bits_is_no_sample():
    items = fed(Intake(), sample(0), sample(SEQUENCE_WRAP, micros=STEP_US))
    assert reasons(items) == ["sequence out of range"]


@pytest.mark.parametrize("jump_us", [20 * MINUTE_US, 60 * MINUTE_US, -20 * MINUTE_US, -60 * MINUTE_US, 10_000_000])
def test_a_clock_that_jumps_is_bridged_by_the_hosts(jump_us):
    intake = Intake()
    items = line_of_time(intake, 40) + line_of_time(intake, 40, start=40, offset_us=jump_us)
    assert len(rows(items)) == 79  # the first one after the jump is held for a glitch
    assert sum(intake.bad.values()) == 1
    assert events(items) == ["start", "clock jump"]
    assert all(later - earlier <= 3 * STEP_US for earlier, later in pairwise(times_us(items)))


@pytest.mark.parametrize("off_us", [20 * MINUTE_US, -MINUTE_US])
def test_one_wrong_stamp_is_a_rejected_line_and_no_jump(off_us):
    intake = Intake()
    items = line_of_time(intake, 10)
    items += fed(intake, sample(10, micros=(10 * STEP_US + off_us) % MICROS_WRAP), host_s=0.24)
    items += line_of_time(intake, 10, start=11)
    assert rows(items) == [*range(10), *range(11, 21)]
    assert times_us(items) == [n * STEP_US for n in (*range(10), *range(11, 21))]
    assert events(items) == ["start", "loss"]


def test_a_device_that_counts_anew_is_not_rejected_for_ever():
    intake = Intake()
    items = line_of_time(intake, 500) + line_of_time(intake, 100, start=500, number_offset=-480)
    assert len(rows(items)) >= 590
    assert "renumbered" in events(items)
    assert intake.lost < 20


def test_one_number_too_far_ahead_does_not_make_the_lines_behind_it_late():
    """A late line carries an old time: these were taken after the one with the wrong number."""
    intake = Intake()
    items = fed(intake, *(sample(n) for n in range(20)), sample(520, micros=20 * STEP_US))
    items += fed(intake, *(sample(n) for n in range(21, 100)))
    assert rows(items)[-60:] == list(range(40, 100))
    assert events(items) == ["start", "loss", "renumbered"]


def test_a_buffer_that_comes_twice_is_no_new_count():
    """The same lines again carry old times, however many they are."""
    intake = Intake()
    items = line_of_time(intake, 60)
    for n in range(20, 60):
        items += fed(intake, sample(n), host_s=2.0)
    assert intake.bad == {"repeated": 40}
    assert events(items) == ["start"]


def lines_of_boot(intake: Intake, boot: int, count: int, start_s: float, start: int = 0, pace: float = 1.0) -> list:
    """`count` samples of one boot, with a count and a clock that begin at `start`."""
    items = []
    for n in range(count):
        one = sample(start + n, boot=boot, micros=(start + n) * STEP_US)
        items += fed(intake, one, host_s=start_s + n * STEP_US / 1e6 / pace)
    return items


@pytest.mark.parametrize("boots", [(7, 7), (7, 8, 7), (7, 8, 7, 8)])
@pytest.mark.parametrize("start", [0, 3000])
def test_a_device_that_begins_anew_under_an_old_boot_number_is_not_rejected_for_ever(boots, start):
    intake, items = Intake(), []
    for number, boot in enumerate(boots):
        items += lines_of_boot(intake, boot, 500, 13.0 * number, 0 if number else start)
    refused = sum(intake.bad.values())
    assert 0 < refused <= 1.2 * 1e6 / STEP_US * (len(boots) - 1)  # a second of each boot
    assert len(rows(items)) == 500 * len(boots) - refused
    assert events(items).count("reboot") == len(boots) - 1
    assert intake.lost == 0
    times = times_us(items)
    assert all(later > earlier for earlier, later in pairwise(times))
    assert times[-1] == pytest.approx((13.0 * (len(boots) - 1) + 499 * STEP_US / 1e6) * 1e6, abs=STEP_US)


@pytest.mark.parametrize("pace", [1.3, 100.0])
def test_a_long_buffer_that_comes_again_is_no_reboot(pace):
    intake = Intake()
    lines_of_boot(intake, 7, 500, 0.0)
    lines_of_boot(intake, 8, 500, 13.0)
    items = lines_of_boot(intake, 7, 500, 26.0, pace=pace)
    items += lines_of_boot(intake, 8, 500, 40.0, pace=pace)
    assert rows(items) == []
    assert intake.bad == {"from before reboot": 500, "repeated": 500}


def test_late_lines_between_good_ones_are_no_reboot():
    intake = Intake()
    lines_of_boot(intake, 7, 500, 0.0)
    items = []
    for n in range(500):
        items += lines_of_boot(intake, 8, 1, 13.0 + n * STEP_US / 1e6, start=n)
        items += lines_of_boot(intake, 7, 1, 13.0 + n * STEP_US / 1e6, start=n)
    assert len(rows(items)) == 500
    assert events(items) == ["reboot"]


def test_a_number_that_jumps_by_billions_is_no_loss_of_billions():
    intake = Intake()
    line_of_time(intake, 30)
    fed(intake, sample(2_000_000_000, micros=30 * STEP_US), host_s=0.72)
    items = line_of_time(intake, 30, start=31)
    assert len(rows(items)) == 30
    assert intake.lost == 1
    assert intake.bad == {"number jumps": 1}


@settings(max_examples=200)
@given(st.lists(st.tuples(st.integers(0, SEQUENCE_WRAP - 1), st.integers(0, MICROS_WRAP - 1), st.floats(0, 1e6))))
def test_whatever_a_device_says_time_runs_forward_and_no_faster_than_it_can(lines):
    intake = Intake()
    items, host_s = [], 0.0
    for number, micros, step_s in lines:
        host_s += step_s
        items += fed(intake, sample(number, micros=micros), host_s=host_s)
    times = times_us(items)
    assert all(later > earlier for earlier, later in pairwise(times))
    assert not times or times[-1] <= 1.1 * host_s * 1e6 + len(times) * 5_000_001 + MICROS_WRAP / 2
    assert intake.lost >= 0


# Two devices on one wire.


def taking_turns(first: dict, second: dict, count: int, burst: int = 1, seed: int = 1) -> list[tuple[float, Sample]]:
    """Host times and lines of two devices, `burst` lines at a time, jittered; given are boot, number and clock."""
    jitter_us = default_rng(seed).integers(0, 2000, (2, count))
    lines = []
    for device, about in enumerate((first, second)):
        for n in range(count):
            micros = about.get("clock_us", 0) + n * STEP_US + int(jitter_us[device, n])
            one = sample(about.get("number", 0) + n, boot=about.get("boot", 7), micros=micros)
            host_s = ((n // burst * burst + burst) * STEP_US + n + 2000 * device) / 1e6
            lines.append((host_s, one._replace(resistance_mohm=1000 * (device + 1) + n)))
    return sorted(lines)


OTHERS = {
    "another boot": {"boot": 8},
    "another boot, much longer on": {"boot": 8, "number": 100_000, "clock_us": 40 * MINUTE_US},
    "the same boot, switched on together": {},
    "the same boot, a little ahead": {"number": 3, "clock_us": 3 * STEP_US},
    "the same boot, ahead": {"number": 100, "clock_us": 100 * STEP_US},
    "the same boot, behind": {"number": -100, "clock_us": -100 * STEP_US},
    "the same boot, another clock": {"number": 40, "clock_us": 20 * MINUTE_US},
    "the same boot, more lines in less time": {"number": 500, "clock_us": -MINUTE_US},
}


@pytest.mark.parametrize("burst", [1, 5])
@pytest.mark.parametrize("other", OTHERS)
@pytest.mark.parametrize("swapped", [False, True])
def test_two_devices_on_one_wire_are_told_once_and_on_the_screen(other, burst, swapped):
    about = [{"number": 1000, "clock_us": 1000 * STEP_US}]
    about.append({name: about[0].get(name, 0) + OTHERS[other].get(name, 0) for name in ("number", "clock_us")})
    about[1]["boot"] = OTHERS[other].get("boot", 7)
    intake, watchdog, items = Intake(), Watchdog(), []
    # Of the same boot number, the lines of one behind are as late ones until it has caught up.
    for host_s, one in taking_turns(*(reversed(about) if swapped else about), count=600, burst=burst):
        items += fed(intake, one, host_s=host_s)
        watchdog.look(host_s, True, intake)
    assert events(items).count("two devices") == 1
    assert watchdog.message.startswith("two devices seem to talk on this wire (boot 0000000")
    assert watchdog.message.endswith(": disconnect one and record anew")


def test_two_devices_that_garble_each_other_are_told_by_what_arrives():
    chance = default_rng(2)
    intake, items = Intake(), []
    for host_s, one in taking_turns({}, {"boot": 8}, count=600):
        items += fed(intake, one, host_s=host_s) if chance.random() > 0.3 else []
    assert events(items).count("two devices") == 1


def test_another_device_that_measures_something_else_is_told_too():
    intake, items = Intake(), []
    for host_s, one in taking_turns({}, {"boot": 8}, count=100):
        items += fed(intake, one if one.boot == 7 else one._replace(force_uN=None), host_s=host_s)
    assert events(items) == ["start", "two devices"]
    assert intake.bad == {"other channels": 100}


@pytest.mark.parametrize("behind", [1, 3, 100])
def test_an_echo_is_no_second_device(behind):
    """Every line comes again, `behind` lines later."""
    intake, items = Intake(), []
    for n in range(500):
        items += fed(intake, sample(n), host_s=n * STEP_US / 1e6)
        items += fed(intake, sample(n - behind), host_s=n * STEP_US / 1e6) if n >= behind else []
    assert events(items) == ["start"]
    assert len(rows(items)) == 500


@settings(max_examples=100)
@given(st.lists(st.integers(0, 12), min_size=100, max_size=300), st.integers(1, 4))
def test_lines_that_overtake_each_other_are_no_second_device(delays, boots):
    """One device, restarted now and then, whose lines each come up to twelve lines late."""
    lines = [sample(n, boot=n * boots // len(delays)) for n in range(len(delays))]
    intake, items = Intake(), []
    for n, one in sorted((n + delay, one) for n, (delay, one) in enumerate(zip(delays, lines, strict=True))):
        items += fed(intake, one, host_s=n * STEP_US / 1e6)
    assert "two devices" not in events(items)


# What a person is told.


def watched(parts, tmp_path, intake=None):
    """All events and messages of a recording."""
    said: list[str] = []
    sink = Sink(tmp_path)
    Recorder(intake or Intake(), sink, 25.0, report=lambda status: said.append(status.message)).run(
        [*parts, End(1e5)]
    )
    sink.close()
    found = [json.loads(line) for line in (tmp_path / "events.jsonl").read_text().splitlines()]
    return {event["event"]: event for event in found}, said


def good_lines(count: int, step_s: float = 0.024, start: int = 0, rate: float = 1.0):
    for n in range(start, start + count):
        line = encode(sample(n, micros=round(n * step_s * rate * 1e6) % MICROS_WRAP))
        yield Chunk(n * step_s, line)


def test_a_port_that_stays_silent_is_said(tmp_path):
    found, said = watched([Tick(n * 0.1) for n in range(60)], tmp_path)
    assert found["silent"]["bytes"] is False
    assert any("no bytes for 4 s: is the device on" in message for message in said)


def test_a_device_that_falls_silent_is_said_and_forgotten_when_it_speaks(tmp_path):
    parts = [*good_lines(200), *(Tick(4.8 + n * 0.1) for n in range(60)), *good_lines(300, start=460)]
    found, said = watched(parts, tmp_path)
    assert "silent" in found
    assert any("no bytes" in message for message in said)
    assert "no bytes" not in said[-2]


def test_bytes_without_lines_hint_at_the_baud_rate(tmp_path):
    found, said = watched([Chunk(n * 0.5, b"\x00\xf8") for n in range(12)], tmp_path)
    assert found["silent"]["bytes"] is True
    assert any("no whole line for 4 s: wrong baud rate?" in message for message in said)


def test_a_slow_device_is_not_silent(tmp_path):
    parts = []
    for n in range(20):
        parts += [Chunk(n * 10.0, encode(sample(n, micros=n * 10_000_000)))]
        parts += [Tick(n * 10.0 + 0.5 * k) for k in range(1, 20)] if n > 2 else []
    found, _ = watched(parts, tmp_path)
    assert "silent" not in found


def test_a_slow_device_is_not_silent_after_a_resume_either(tmp_path):
    intake = Intake(channels=channels_of(sample(0)), accepted=1000)
    intake.continue_from(Anchor(7, 0, 10_000_000_000, 0.0), 999)
    parts = [Chunk(10.0 * n, encode(sample(999 + n, micros=n * 10_000_000))) for n in range(1, 20)]
    parts += [Tick(0.5 * k) for k in range(61, 400)]  # three lines say how often one comes
    found, _ = watched(sorted(parts, key=lambda part: part.host_s), tmp_path, intake)
    assert "silent" not in found


def test_lines_that_are_nearly_all_rejected_are_said_with_their_reason(tmp_path):
    garbage = [Chunk(n * 0.02, b"\xf8\x00\xfe\x80K1,\xff\n") for n in range(400)]
    found, said = watched(garbage, tmp_path)
    assert found["mostly rejected"]["share"] == 1.0
    assert any("100 % of the lines are rejected (no start): wrong baud rate?" in message for message in said)


def test_a_clock_that_stands_still_is_said(tmp_path):
    frozen = [Chunk(n * 0.02, encode(sample(n, micros=7))) for n in range(400)]
    _, said = watched(frozen, tmp_path)
    assert any("(time stands still): does the device's clock run?" in message for message in said)


@pytest.mark.parametrize(("rate", "told"), [(1.0, False), (1.001, False), (0.9, True), (1.05, True)])
def test_a_clock_that_runs_at_another_pace_is_said(tmp_path, rate, told):
    found, said = watched(good_lines(4000, 0.05, rate=rate), tmp_path)
    assert ("clock disagrees" in found) is told
    assert any("while the host's ran" in message for message in said) is told


@pytest.mark.parametrize("lie", ["jump", "reboots"])
def test_a_clock_that_was_lost_is_said_on_the_screen_too(lie):
    intake, watchdog = Intake(), Watchdog()
    for n in range(60):
        boot = n if lie == "reboots" else 7
        off_us = 20 * MINUTE_US if lie == "jump" and n >= 30 else 0
        fed(intake, sample(n, boot=boot, micros=(n * STEP_US + off_us) % MICROS_WRAP), host_s=n * STEP_US / 1e6)
        watchdog.look(n * STEP_US / 1e6, True, intake)
    jumped = "the device's clock jumped 1 times: the host's bridged it"
    restarted = "the device restarted (59 times): if its encoder counts from zero, displacement and strain"
    assert watchdog.message.startswith(restarted if lie == "reboots" else jumped)


def test_the_watchdog_says_nothing_of_a_healthy_device():
    intake, dog = Intake(), Watchdog()
    for part in good_lines(5000):
        list(intake.feed(part.data, part.host_s))
        assert dog.look(part.host_s, True, intake) == []
        assert dog.message == ""
