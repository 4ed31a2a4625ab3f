"""What every method starts from."""

from __future__ import annotations

from dataclasses import replace

import pytest

from compensation.series.preprocessing import series_of
from compensation.training.options import Options
from compensation.training.untrained import untrained


@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_the_level_of_a_recording_says_nothing_of_the_direction(recordings, turned):
    """A sensor that is higher by a lot on the day on which the force was low is no sensor that falls."""
    one, other = (series_of(recording.between(0, 60), "force", 20.0) for recording in recordings[:2])
    spread_S = one.conductance_S.std()
    higher = replace(
        other, conductance_S=other.conductance_S + 20 * spread_S, truth=other.truth - 5 * one.truth.std()
    )
    series = [replace(part, conductance_S=1.0 + turned * part.conductance_S) for part in (one, higher)]
    assert untrained(series, "force", Options()).sign == turned
