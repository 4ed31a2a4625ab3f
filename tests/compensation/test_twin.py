"""From the twin: a network that has seen the model's campaigns knows more than two minutes can teach."""

from __future__ import annotations

import numpy as np
import pytest

from compensation import twin
from compensation.cli import main
from compensation.preprocessing import series_of
from compensation.score import r2
from compensation.training import Options, train_on_series
from testbench.knit.catalogue import baseline
from testbench.recording_files import write_recording_csv


@pytest.fixture(scope="module", autouse=True)
def one_campaign_two_networks():
    """Shorter than in earnest."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(twin, "TWIN_SEEDS", (901,))
        patch.setattr(twin, "NETWORKS", 2)
        yield


def test_twin_beats_a_short_recording_alone(recordings):
    """With the right model: what 12 s have not shown is known beforehand."""
    short = series_of(recordings[0].between(0, 12), "force", 20.0)
    later = series_of(recordings[1], "force", 20.0)
    alone = train_on_series([short], "force", Options())
    compensator = twin.train_from_twin(baseline(), short, "force", 25.0, 0.3)
    scores = [r2(later.truth, one.predict_series(later)) for one in (compensator, alone)]
    assert scores[0] > scores[1] + 0.1


def test_simulated_campaigns_differ_and_stay_in_range():
    first, second = twin.simulated(baseline(), "displacement", 25.0, 0.3, 20.0, (901, 902))
    assert first.truth.min() == pytest.approx(0.0)
    assert first.truth.max() == pytest.approx(7.5)
    count = min(len(first), len(second))
    assert abs(np.corrcoef(first.truth[:count], second.truth[:count])[0, 1]) < 0.5


def test_command_refuses_what_it_cannot_use(recordings, tmp_path, capsys):
    recording, model = tmp_path / "r.csv", tmp_path / "m.json"
    write_recording_csv(recording, recordings[0].between(0, 30))
    model.write_text("{}")
    words = ["train", str(recording), "--gauge-length-mm", "25", "--target", "force", "-o", str(tmp_path / "c.json")]
    for extra, match in (
        (["--twin", str(model)], "m.json"),
        (["--twin", str(model), "--strain", "9"], "--strain must be"),
    ):
        assert main([*words, *extra]) == 2
        assert match in capsys.readouterr().err
    assert not (tmp_path / "c.json").exists()
