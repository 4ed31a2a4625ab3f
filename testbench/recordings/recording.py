"""A recording: time and named channels, exactly as sampled.

File format ``recording.csv``: header ``time_s,displacement_mm,force_N,resistance_ohm`` plus optional channels
(``temperature_C``). Rows are as sampled: jittered, never resampled. ``force_N`` or ``resistance_ohm`` may be absent;
where both are there, ``displacement_mm`` may be.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any
from zlib import crc32

import numpy as np

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from gcode.support.kinds import is_number, number, whole
from gcode.support.read_only import Unchanging, read_only_array
from testbench.recordings.channels import DISPLACEMENT, RESISTANCE, TIME
from testbench.recordings.checks import check
from testbench.recordings.columns import numbers

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

GAP_S, GAP_STEPS = 1.0, 10.0
MOST_RESAMPLED, MOST_MADE_UP = 20_000_000, 1_000_000


def gaps_in(time_s: FloatArray) -> tuple[tuple[float, float], ...]:
    """Where there is no sample: (last time before, first time after), in seconds, in order.

    A step is a gap if it is longer than a second and than ten usual ones.

    Parameters
    ----------
    time_s : ndarray, shape (n,)
        Increasing.
    """
    steps_s = np.diff(time_s)
    usual_s = float(np.median(steps_s)) if len(steps_s) else 0.0
    rows = np.flatnonzero(steps_s > max(GAP_S, GAP_STEPS * usual_s))
    return tuple((float(time_s[row]), float(time_s[row + 1])) for row in rows)


def recorded_time_s(time_s: FloatArray) -> FloatArray:
    """Time in s since the first sample, during which something was recorded: as if the gaps were closed.

    Parameters
    ----------
    time_s : ndarray, shape (n,)
        Increasing.
    """
    gaps = np.reshape(gaps_in(time_s), (-1, 2))
    missing_s = np.concatenate([[0.0], np.cumsum(np.diff(gaps))])
    return time_s - time_s[0] - missing_s[np.searchsorted(gaps[:, 1], time_s, side="right")]


def recorded_duration_s(time_s: FloatArray) -> float:
    """How long something was recorded, from the first sample to the last."""
    return float(recorded_time_s(time_s)[-1])


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Unchanging):
    """Time and named channels of one run; none of them is changed in place.

    Attributes
    ----------
    time_s : ndarray, shape (n,)
        Sample times, strictly increasing.
    channels : mapping of str to ndarray, each shape (n,)
        ``displacement_mm``, ``force_N`` and ``resistance_ohm`` where measured (a displacement, or force and
        resistance, always); others by name and unit.
    gauge_length_mm : float
        Length of the unstretched sensor between the clamps; NaN where no displacement was recorded.
    source : str
        File or campaign it came from; errors name it, and a model knows by it what it was fitted on. Default:
        ``columns-`` and its `digest`.
    metadata : mapping
        Anything else that is known (sensor, seed, trajectory).

    Examples
    --------
    >>> import testbench as tb
    >>> recording = tb.read({"time_s": [0, 1, 2], "displacement_mm": [0, 5, 0], "force_N": [0, 2, 0]}, 25)
    >>> recording.strain.max().item(), recording["force_N"].max().item()
    (0.2, 2.0)
    """

    time_s: FloatArray
    channels: Mapping[str, FloatArray]
    gauge_length_mm: float
    source: str = ""
    metadata: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.source, str):
            raise UserError(f"recording: source must be a text such as a file's name, got {self.source!r}")
        who = self.source or "recording"
        _check_kinds(who, self.channels, self.metadata)
        columns = {TIME: self.time_s, **self.channels}
        arrays = {name: numbers(who, name, values) for name, values in columns.items()}
        object.__setattr__(self, "time_s", arrays.pop(TIME))
        object.__setattr__(self, "channels", arrays)
        if not self.source:
            object.__setattr__(self, "source", f"columns-{self.digest}")
        super().__post_init__()
        check(self.source, self.time_s, self.channels, self.gauge_length_mm)

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        known = f"gauge length {self.gauge_length_mm:g} mm, " if np.isfinite(self.gauge_length_mm) else ""
        return f"<Recording {self.source}: {self._size}, {known}{', '.join(self.channels)}>"

    @property
    def digest(self) -> str:
        """Eight hexadecimal digits that tell the samples of recordings apart."""
        sum_ = 0
        for values in (self.time_s, *self.channels.values()):
            sum_ = crc32(values.tobytes(), sum_)
        return f"{sum_:08x}"

    @property
    def _size(self) -> str:
        return f"{len(self)} samples in {self.duration_s:.1f} s"

    def _repr_html_(self) -> str:
        from testbench.recordings.showing import as_html, titled

        lines = [f"{self._size}, {self.mean_rate_hz:.3g} Hz on average", *self._notes()]
        return as_html(self.source, lines, self.time_s, titled(self.channels, self.gauge_length_mm), self.gaps)

    def _notes(self) -> list[str]:
        gauge = [f"gauge length {self.gauge_length_mm:g} mm"] if np.isfinite(self.gauge_length_mm) else []
        return gauge + [f"nothing was recorded from {start:.4g} to {end:.4g} s" for start, end in self.gaps]

    def plot(self, axes: Axes | Sequence[Axes] | None = None) -> Any:
        """Draw every channel over time, one panel a channel; where nothing was recorded, there is no line.

        Parameters
        ----------
        axes : Axes or sequence of Axes, optional
            Where to draw; default: a new figure.

        Returns
        -------
        ndarray of Axes, shape (channels,)
        """
        from testbench.recordings.showing import plot, titled

        return plot(self.time_s, titled(self.channels, self.gauge_length_mm), axes, self.gaps)

    def to_frame(self) -> pd.DataFrame:
        """Samples as a table: a row a sample, ``time_s`` and every channel a column."""
        import pandas as pd

        return pd.DataFrame({TIME: self.time_s, **self.channels})

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: where it came from, the gauge length in mm (None if unknown), and every column."""
        columns = {TIME: self.time_s, **self.channels}
        gauge = self.gauge_length_mm if np.isfinite(self.gauge_length_mm) else None
        return {
            "source": self.source,
            "gauge_length_mm": gauge,
            "columns": {name: values.tolist() for name, values in columns.items()},
        }

    def __getitem__(self, name: str) -> FloatArray:
        try:
            return self.channels[name]
        except (KeyError, TypeError):  # TypeError: a slice is no key
            have = ", ".join(self.channels)
            rows = "; `between` takes samples by their time" if isinstance(name, (int, slice)) else ""
            raise UserError(f"{self.source}: no channel {name}; it has {have}{rows}") from None

    def __contains__(self, name: object) -> bool:
        return name in self.channels

    def __iter__(self) -> Iterator[str]:
        """Names of the channels, as the columns of a data frame; ``len`` is the number of samples."""
        return iter(self.channels)

    def has(self, name: str) -> bool:
        """Whether the channel `name` was recorded."""
        return name in self.channels

    def needs_displacement(self) -> None:
        """Raise `UserError` where no displacement was recorded."""
        if DISPLACEMENT not in self.channels:
            have = ", ".join(self.channels)
            raise UserError(
                f"{self.source}: no displacement was recorded, and a model of the sensor needs it; it has {have}, "
                "which is enough for `compensation train --target force`"
            )

    @cached_property
    def strain(self) -> FloatArray:
        """Nominal strain: displacement over gauge length (dimensionless)."""
        self.needs_displacement()
        return read_only_array(self[DISPLACEMENT] / self.gauge_length_mm)

    @cached_property
    def conductance_S(self) -> FloatArray:
        """Conductance G = 1/R in siemens."""
        return read_only_array(1.0 / self[RESISTANCE])

    @property
    def duration_s(self) -> float:
        """From the first to the last sample."""
        return float(self.time_s[-1] - self.time_s[0])

    @property
    def mean_rate_hz(self) -> float:
        """Mean sampling rate while it was recorded: gaps do not count."""
        return (len(self) - 1 - len(self.gaps)) / (self.duration_s - self.missing_s)

    def between(self, start_s: float, end_s: float) -> Recording:
        """The samples with ``start_s <= time_s < end_s``; time is kept as it was.

        Raises
        ------
        UserError
            If there are too few for a recording, or either end is no number.
        """
        start_s, end_s = number("start_s", start_s), number("end_s", end_s)
        inside = (self.time_s >= start_s) & (self.time_s < end_s)
        if (count := int(inside.sum())) < 2:
            raise UserError(
                f"{self.source}: a recording needs at least 2 samples, got {count} from {start_s:g} to {end_s:g} s; "
                f"it goes from {self.time_s[0]:g} to {self.time_s[-1]:g} s"
            )
        return self._rows(inside)

    def thinned(self, every: int) -> Recording:
        """Every n-th sample, where n is `every`, the first one included.

        Raises
        ------
        UserError
            If `every` is no whole number of 1 or more, or too few samples are left.
        """
        every = whole(f"{self.source}: every", every, 1)
        return self if every == 1 else self._rows(slice(None, None, every))

    def _rows(self, rows: np.ndarray | slice) -> Recording:
        return replace(
            self,
            time_s=self.time_s[rows],
            channels={name: values[rows] for name, values in self.channels.items()},
        )

    @cached_property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """Where nothing was recorded, see `gaps_in`."""
        return gaps_in(self.time_s)

    @property
    def missing_s(self) -> float:
        """How long nothing was recorded, all gaps together."""
        return float(sum(end_s - start_s for start_s, end_s in self.gaps))

    def segments(self) -> list[Recording]:
        """The parts between gaps, of two samples or more each; time is kept as it was."""
        edges = [0, *np.searchsorted(self.time_s, [end_s for _, end_s in self.gaps]), len(self)]
        return [self._rows(slice(begin, end)) for begin, end in pairwise(edges) if end - begin > 1]

    def resampled(self, rate_hz: float) -> Recording:
        """Linear interpolation on a uniform grid at `rate_hz`, starting at the first sample.

        Parameters
        ----------
        rate_hz : float

        Raises
        ------
        UserError
            If the rate is no number above 0; if most of that grid would be made up: more than a million points in
            gaps. A gap of a day is a gap; see `segments`. So, too, if it would have more than 20 million points.
        """
        if not is_number(rate_hz) or not rate_hz > 0:
            raise UserError(f"{self.source}: the rate must be a number of Hz above 0, got {rate_hz!r}")
        count = int(np.floor(min(self.duration_s * rate_hz, 1e18) * (1 + 1e-12))) + 1
        made_up = rate_hz * self.missing_s
        if count > MOST_RESAMPLED or made_up > max(MOST_MADE_UP, len(self)):
            raise UserError(f"{self.source}: {self._why_not(count, rate_hz)}")
        grid = self.time_s[0] + np.arange(count) / rate_hz
        channels = {name: np.interp(grid, self.time_s, values) for name, values in self.channels.items()}
        return replace(self, time_s=grid, channels=channels)

    def _why_not(self, count: int, rate_hz: float) -> str:
        longest = max(self.gaps, key=lambda gap: gap[1] - gap[0], default=None)
        many = f"a uniform grid of {rate_hz:g} Hz would have {count:.3g} points"
        if longest is None:
            return f"{many}; cut the recording into shorter ones, or give a lower rate"
        start_s, end_s = longest
        gap = f"nothing was recorded for {end_s - start_s:.4g} s after {start_s:.4g} s"
        return f"{gap}, and {many}, most of them made up; cut the recording there and use the parts"


def _check_kinds(source: str, channels: object, metadata: object) -> None:
    """Refuse channels that are no mapping of names to samples, or metadata that is no mapping.

    Raises
    ------
    UserError
    """
    if not isinstance(channels, Mapping):
        raise UserError(
            f"{source}: channels must be a mapping of names to samples, got {type(channels).__name__}; "
            "testbench.read makes a Recording of a data frame"
        )
    if strange := [name for name in channels if not isinstance(name, str)]:
        raise UserError(f"{source}: a channel's name must be a text such as force_N, got {strange[0]!r}")
    if not isinstance(metadata, Mapping):
        raise UserError(f"{source}: metadata must be a mapping, got {type(metadata).__name__}; leave it out")
