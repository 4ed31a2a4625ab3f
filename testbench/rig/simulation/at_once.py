"""A simulated rig that delivers at once: the bytes that a recorder would write, without the way over the wire.

None of its lines is damaged, late or lost, so none has to be encoded, checked, decoded and judged; that takes four
times as long as the simulation. Where the recorder would have had something to say (a gap of more than a second, a
number that no line can carry), the lines go over the wire after all.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gcode.support.arrays import IntArray
from testbench.rig.connection.parts import Accepted, End, Part, in_memory
from testbench.rig.protocol import wire
from testbench.rig.protocol.items import CARRIED, Row, header_line
from testbench.rig.protocol.stream import GAP_US
from testbench.rig.simulation.simulated import Readings, SimulatedRig

BATCH = 512  # lines, as `in_memory` has them


def at_once(rig: SimulatedRig) -> Iterator[Part]:
    """A link that delivers everything that `rig` reads, on a host clock that stands still."""
    readings = rig.readings()
    if not is_plain(readings):
        yield from in_memory(readings.lines())
        return
    time_us = np.concatenate([[0], np.cumsum(_steps_us(readings))])
    header = header_line(Row(0, readings.sample(0)))
    for start in range(0, len(time_us), BATCH):
        end = min(start + BATCH, len(time_us))
        first, last = (Row(int(time_us[number]), readings.sample(number)) for number in (start, end - 1))
        yield Accepted(0.0, first, last, end - start, header + csv_lines(readings, time_us, slice(start, end)))
        header = ""
    yield End(0.0)


def is_plain(readings: Readings) -> bool:
    """Whether a recorder would accept every line, without a remark."""
    steps_us = _steps_us(readings)
    resistance = readings.resistance_mohm
    return bool(
        np.all((steps_us > 0) & (steps_us <= GAP_US))
        and _fits(readings.displacement_nm, wire.DISPLACEMENT_DIGITS)
        and _fits(readings.force_uN, wire.FORCE_DIGITS)
        and _fits(readings.temperature_mC, wire.TEMPERATURE_DIGITS)
        and _fits(resistance, wire.RESISTANCE_DIGITS)
        and (resistance is None or np.all(resistance >= 0))
    )


def _fits(values: IntArray | None, digits: int) -> bool:
    return values is None or bool(np.all(np.abs(values) < 10**digits))


def _steps_us(readings: Readings) -> IntArray:
    return np.diff(readings.micros) % wire.MICROS_WRAP


def csv_lines(readings: Readings, time_us: IntArray, rows: slice) -> str:
    """Lines of ``recording.csv``, the same as `testbench.rig.protocol.items.csv_line` makes of one row each."""
    read = ((getattr(readings, one.field), one.scale, one.decimals) for one in CARRIED)
    columns = [(time_us, 1e6, "%.6f"), *(column for column in read if column[0] is not None)]
    line = ",".join(decimals for *_, decimals in columns) + "\n"
    numbers = np.column_stack([values[rows] / scale for values, scale, _ in columns])
    return line * len(numbers) % tuple(numbers.ravel().tolist())
