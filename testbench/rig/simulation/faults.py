"""A bad cable: lines garbled, truncated, doubled and out of order, by a seed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from numpy.random import Generator


def garbled(line: bytes, rng: Generator) -> bytes:
    """One to four bytes replaced by others; the line feed may be hit too."""
    data = bytearray(line)
    for at in rng.integers(0, len(data), rng.integers(1, 5)):
        data[at] ^= int(rng.integers(1, 256))
    return bytes(data)


def truncated(line: bytes, rng: Generator) -> bytes:
    """A line that lost its end, with its line feed half of the time."""
    return line[: rng.integers(1, len(line) - 1)] + (b"\n" if rng.random() < 0.5 else b"")


def doubled(line: bytes, rng: Generator) -> bytes:
    """The same line twice."""
    return line + line


DAMAGES: tuple[Callable[[bytes, Generator], bytes], ...] = (garbled, truncated, doubled)


def faulty(lines: Iterable[bytes], share: float, rng: Generator) -> Iterator[bytes]:
    """Damage a share of the lines: garbled, truncated, doubled or late by one, in equal parts."""
    held = b""
    for line in lines:
        if rng.random() >= share:
            yield line + held
            held = b""
            continue
        kind = rng.integers(0, len(DAMAGES) + 1)
        if kind < len(DAMAGES):
            yield DAMAGES[kind](line, rng) + held
            held = b""
        else:
            held += line
    if held:
        yield held
