"""What a link delivers, with the host's time: bytes, samples, silence, the loss of the port, the end."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import NamedTuple

from testbench.rig.protocol.items import Row
from testbench.rig.protocol.wire import MICROS_WRAP, decode


class Chunk(NamedTuple):
    """Bytes that came at `host_s`."""

    host_s: float
    data: bytes


class Accepted(NamedTuple):
    """Samples without any fault, as lines of the file already. No limit looks at them, and nothing follows them."""

    host_s: float
    first: Row
    last: Row
    samples: int
    text: str


class Lost(NamedTuple):
    """The port was lost at `host_s`; the link is trying to get it back."""

    host_s: float
    reason: str


class Tick(NamedTuple):
    """Nothing came; time goes on."""

    host_s: float


class End(NamedTuple):
    """The link will deliver nothing more; `state` becomes the recording's."""

    host_s: float
    state: str = "complete"
    message: str = ""


Part = Chunk | Accepted | Lost | Tick | End


def in_memory(lines: Iterable[bytes], size: int = 512) -> Iterator[Part]:
    """A link that delivers lines as fast as they are taken, on a host clock that stands still."""
    iterator = iter(lines)
    while chunk := b"".join(islice(iterator, size)):
        yield Chunk(0.0, chunk)
    yield End(0.0)


def paced(
    lines: Iterable[bytes],
    speed: float = 1.0,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> Iterator[bytes]:
    """Deliver lines when their device time has come, `speed` times faster than real; tests bring their own clock."""
    due_s, before = None, 0
    for line in lines:
        micros = decode(line.rstrip()).micros
        # The clock starts with the first line: whatever made the lines may have needed a while.
        due_s = clock() if due_s is None else due_s + (micros - before) % MICROS_WRAP / 1e6 / speed
        before = micros
        if (wait_s := due_s - clock()) > 0:
            sleep(wait_s)
        yield line


def real_time(lines: Iterable[bytes]) -> Iterator[Part]:
    """A link that delivers the simulated rig's lines as a real one would."""
    for line in paced(lines):
        yield Chunk(time.monotonic(), line)
    yield End(time.monotonic())
