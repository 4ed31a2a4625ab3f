"""`compare`: where a model fails."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support.errors import UserError
from gcode.support.figures import picture
from gcode.support.html import card, table
from testbench.api.arguments import (
    AnyModel,
    Effects,
    Source,
    catalogue_of,
    model_file_of,
    recording_of,
    recordings_for,
)
from testbench.comparing import compare as comparing
from testbench.comparing.compare import Comparison
from testbench.comparing.judged import Judged, judged
from testbench.comparing.model_errors import channel_name
from testbench.comparing.tables import comparison_table
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.preparing import prepare
from testbench.measurements.responses import UNIT_OF
from testbench.recordings.recording import Recording
from testbench.report.figures.residual_figures import profile
from testbench.report.writing.static import draw_on
from testbench.results.model_file import ModelFile, same_source

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class ComparisonResult:
    """Where a model fails.

    Attributes
    ----------
    comparison : Comparison
        Errors, noise floors, and the mean residual over every coordinate.
    model : KnitModel
        With what belongs to one recording (the phase of a hum) fitted to this one.
    judged : Judged
        The samples that count, what is free in them, and the zero of displacement where the sensor was clamped anew.
    notes : tuple of str
        What a reader should know of these samples.
    """

    comparison: Comparison
    model: KnitModel
    judged: Judged
    notes: tuple[str, ...] = ()

    @property
    def measurement(self) -> Measurement:
        """The samples that the model is judged on."""
        return self.judged.measurement

    @property
    def words(self) -> tuple[str, ...]:
        """The worst places, at most three, one sentence each; empty where none stands out from the noise."""
        return tuple(place.words for place in self.comparison.worst)

    def __repr__(self) -> str:
        return f"<ComparisonResult {'; '.join(self.comparison.places)}>"

    def __str__(self) -> str:
        return comparison_table(self.comparison)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form; the shape is documented in docs/finding-effects.md."""
        return self.comparison.to_dict() | self.judged.to_dict()

    def to_frame(self) -> pd.DataFrame:
        """A row a bin: channel, unit, coordinate, low, high, direction, mean, standard_error, share, t.

        The mean is of measured minus modelled, in `unit` (N or ln S). Where a coordinate's name has no unit, it is 1
        (strain), 1/s (strain_rate) or a count (cycle).
        """
        import pandas as pd

        return pd.DataFrame(
            {"channel": channel, "unit": UNIT_OF[channel], "coordinate": coordinate, **vars(cell), "t": cell.t}
            for channel, maps in self.comparison.maps.items()
            for coordinate, cells in maps.items()
            for cell in cells
        )

    def plot(self, axes: Axes | Sequence[Axes] | None = None, coordinate: str | None = None) -> Any:
        """Draw the mean residual with two standard errors over a coordinate, one panel a channel.

        Parameters
        ----------
        axes : Axes or sequence of Axes, optional
            Default: of a new figure.
        coordinate : str, optional
            ``strain``, ``elapsed_s``, ``since_reversal_s``, ...; default: that of each channel's worst place.

        Returns
        -------
        ndarray of Axes, shape (channels,)
        """
        maps = self.comparison.maps
        chosen = {channel: coordinate or self._worst_coordinate(channel) for channel in maps}
        for channel, name in chosen.items():
            if name not in maps[channel]:
                raise UserError(f"plot: coordinate must be one of {', '.join(maps[channel])}; got {name!r}")
        return draw_on(profile(maps, chosen), axes)

    def _worst_coordinate(self, channel: str) -> str:
        return next((place.coordinate for place in self.comparison.worst if place.channel == channel), "strain")

    def _repr_html_(self) -> str:
        rows = [
            (channel_name(c), f"{rms:.4g} {UNIT_OF[c]}", f"{self.comparison.noise_floor[c]:.2g} {UNIT_OF[c]}")
            for c, rms in self.comparison.rms.items()
        ]
        parts = table(("channel", "RMS error", "noise floor"), rows), picture(self.plot, len(rows))
        lines = [*self.comparison.places, *self.notes]
        return card("Where the model fails", lines, *parts)


def compare(
    recording: Source,
    model: AnyModel,
    *,
    effects: Effects = None,
    gauge_length_mm: float | None = None,
    clamp_play_mm: float = 0.0,
) -> ComparisonResult:
    """Find the places where a model fails on a recording.

    A model that was fitted on the first two thirds of this very recording is judged on the rest. On samples that
    the model was not fitted on, the zero of force and the gain of the conductance are free: they belong to the
    mounting. Of a bare `KnitModel` nobody knows what it was fitted on: all samples count, and nothing is free.

    Parameters
    ----------
    recording : Recording or path
    model : KnitModel, result or path
    effects : path, Catalogue or effect classes, optional
        The user's own effects that the model uses.
    gauge_length_mm : float, optional
        In mm, for the path of a bare CSV; default: the model's.
    clamp_play_mm : float
        Where the sensor was clamped anew for this recording: by how much, in mm, the zero of its displacement may
        have moved (standard deviation). Default: the zero that `fit` found, on the held-out recording of the model.

    Returns
    -------
    ComparisonResult

    Raises
    ------
    UserError
        If the recording is too short or still, or its gauge length is not the model's; if there is clamp play in
        what the model was fitted on.

    Examples
    --------
    >>> import testbench as tb
    >>> recording = tb.example(tb.effects.StressRelaxation(fraction=0.3))
    >>> where = tb.compare(recording, tb.baseline())
    >>> where.words[0].startswith("modelled force is")
    True
    """
    file = model_file_of(model, catalogue_of(effects))
    given, _, _ = recordings_for(model, file, recording, None, gauge_length_mm)
    if isinstance(model, KnitModel) and not clamp_play_mm:
        on = Judged(prepare(given), elsewhere=False)
    else:
        on = judged(file, given, clamp_play_mm, _before(file, given))
    mounted = on.mounted(file.model)
    found = comparing.compare(mounted, on.measurement, free_offset=on.elsewhere)
    return ComparisonResult(found, mounted, on, tuple(on.notes(mounted)))


def _before(file: ModelFile, recording: Recording) -> Recording | None:
    """What a model was fitted on, if it is still there, and this held-out recording is of the same specimen."""
    is_same = file.between.rest_s is not None and same_source(file.held_out, recording.source)
    if not is_same or not Path(file.fitted_on).exists():
        return None
    return recording_of(file.fitted_on, None, file.gauge_length_mm or None)
