"""Links that keep time: a clock is injected, so that tests need none."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator

from testbench.rig.connection.parts import Chunk, End, Part
from testbench.rig.protocol.wire import MICROS_WRAP, decode


def paced(
    lines: Iterable[bytes],
    speed: float = 1.0,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> Iterator[bytes]:
    """Deliver lines when their device time has come, `speed` times faster than real."""
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
