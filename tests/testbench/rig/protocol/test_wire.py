"""The wire protocol: what goes out comes in, and nothing damaged ever does."""

from __future__ import annotations

import zlib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbench.rig.protocol.wire import BadLine, LineBuffer, Sample, decode, encode, rescue

U32 = st.integers(0, 2**32 - 1)
I31 = st.integers(-(2**31), 2**31 - 1)
SAMPLES = st.builds(
    Sample,
    U32,
    U32,
    U32,
    st.none() | I31,
    st.none() | st.integers(0, 10**15 - 1),
    I31,
    st.none() | st.integers(-99_999, 999_999),
)
LINE = encode(Sample(0x5F3A9C01, 1042, 3500123, 1203456, 405600123, 2345678))


def test_the_documented_example_is_what_encode_writes():
    body = b"K1,5f3a9c01,1042,3500123,1203456,405600123,2345678"
    assert b"$%b*%08x\n" % (body, zlib.crc32(body)) == LINE


def test_the_documents_show_a_true_line():
    text = (Path(__file__).parents[4] / "docs" / "wire.md").read_text()
    assert LINE.decode().strip() in text


@settings(max_examples=200)
@given(SAMPLES)
def test_every_sample_survives_the_wire(sample):
    assert decode(encode(sample).rstrip(b"\n")) == sample


@settings(max_examples=400)
@given(SAMPLES, st.data())
def test_no_flipped_byte_is_accepted(sample, data):
    line = bytearray(encode(sample)[:-1])
    line[data.draw(st.integers(0, len(line) - 1))] ^= data.draw(st.integers(1, 255))
    with pytest.raises(BadLine):
        decode(bytes(line))


@settings(max_examples=100)
@given(SAMPLES, st.data())
def test_no_truncated_line_is_accepted(sample, data):
    line = encode(sample)[:-1]
    with pytest.raises(BadLine):
        decode(line[: data.draw(st.integers(0, len(line) - 1))])


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (b"rst:0x1 (POWERON_RESET)", "no start"),
        (LINE[:-6], "no CRC"),
        (LINE[:-1].replace(b"$K1", b"$K2"), "other version"),
        (LINE[:-2] + b"0", "wrong CRC"),
        (LINE[:-1].replace(b"1042", b"10.2"), "malformed"),
    ],
)
def test_the_reason_says_what_is_wrong(line, reason):
    with pytest.raises(BadLine, match=reason):
        decode(line)


def test_micros_beyond_32_bits_are_refused():
    line = encode(Sample(1, 1, 2**32, 0, 1, 0))[:-1]
    with pytest.raises(BadLine, match="micros out of range"):
        decode(line)


def test_a_line_that_lost_its_end_does_not_take_the_next_one_with_it():
    debris, whole = rescue(LINE[:20] + LINE[:-1])
    assert debris == LINE[:20]
    assert decode(whole).sequence == 1042


@settings(max_examples=100)
@given(st.lists(st.integers(1, 80), max_size=60))
def test_lines_come_out_whole_however_the_bytes_are_cut(cuts):
    stream, buffer, lines, start = LINE * 20, LineBuffer(), [], 0
    for cut in cuts:
        lines += buffer.feed(stream[start : start + cut])
        start += cut
    lines += buffer.feed(stream[start:])
    assert lines == [LINE[:-1]] * 20


def test_carriage_returns_are_no_part_of_a_line():
    assert list(LineBuffer().feed(b"$a\r\n$b\n")) == [b"$a", b"$b"]
    assert list(LineBuffer().feed(b"$a\n\r$b\n\r$c\n")) == [b"$a", b"$b", b"$c"]


@pytest.mark.parametrize("debris", [200, 250, 300, 600])
def test_debris_without_a_line_feed_does_not_take_the_next_line_with_it(debris):
    for cut in range(1, len(LINE)):
        buffer = LineBuffer()
        lines = [*buffer.feed(b"x" * debris + LINE[:cut]), *buffer.feed(LINE[cut:])]
        assert rescue(lines[-1])[1] == LINE[:-1]
        assert sum(map(len, lines)) == debris + len(LINE) - 1


def test_debris_without_line_feeds_does_not_grow_for_ever():
    buffer = LineBuffer()
    lines = [line for _ in range(100) for line in buffer.feed(b"\xff" * 100)]
    assert sum(map(len, lines)) + len(buffer.drop()) == 10_000
    assert max(map(len, lines)) <= 256
