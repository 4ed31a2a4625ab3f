"""From the twin: networks that have seen the model's campaigns know more than two minutes can teach."""

from __future__ import annotations

import json

import numpy as np
import pytest

from compensation.cli import main
from compensation.series.preprocessing import series_of
from compensation.series.score import r2
from compensation.training import twin
from compensation.training.options import Options
from compensation.training.training import train_on_series
from gcode.support.errors import UserError
from testbench.fitting.fit import fit
from testbench.knit.catalogue import baseline, load_catalogue
from testbench.knit.model import KnitModel
from testbench.measurements.coarser import coarser
from testbench.measurements.preparing import prepare
from testbench.recordings.files import write_recording_csv


@pytest.fixture(autouse=True)
def few_networks(monkeypatch):
    """Shorter than in earnest."""
    monkeypatch.setattr(twin, "NETWORKS", 2)
    monkeypatch.setattr(twin, "DRAWS", 2)
    monkeypatch.setattr(twin, "OTHERS", 1)


def test_twin_beats_a_short_recording_alone(recordings):
    """What 40 s have not shown is known beforehand."""
    short = recordings[0].between(0, 40)
    later = series_of(recordings[1], "force", 20.0)
    alone = train_on_series([series_of(short, "force", 20.0)], "force", Options())
    notes = []
    compensator = twin.train_from_twin(baseline(), short, "force", 0.3, progress=notes.append)
    scores = [r2(later.truth, one.predict_series(later)) for one in (compensator, alone)]
    assert 1 - scores[0] < 0.5 * (1 - scores[1])
    assert len(notes) == twin.steps()
    assert compensator.recipe["twin_effects"][0] == "permanent_set_recovering"
    assert compensator.recipe["trained_on"] == [short.source]
    assert len(compensator.recipe["twin_campaigns"]) == 2


def test_simulated_campaigns_differ_and_stay_in_range():
    first, second = twin.simulated([baseline()] * 2, "displacement", 25.0, 0.3, 20.0)
    assert first.truth.min() == pytest.approx(0.0)
    assert first.truth.max() == pytest.approx(7.5)
    count = min(len(first), len(second))
    assert abs(np.corrcoef(first.truth[:count], second.truth[:count])[0, 1]) < 0.5


def test_a_model_without_force_is_refused_for_force_only():
    effects = load_catalogue().effects
    electrical = KnitModel.of(effects["piezoresistance"](), effects["drift"]())
    with pytest.raises(UserError, match="makes no force_N"):
        twin.simulated([electrical], "force", 25.0, 0.3, 20.0)
    assert len(twin.simulated([electrical], "displacement", 25.0, 0.3, 20.0)) == 1


def test_memories_are_added_once_and_only_where_their_signals_are():
    effects = load_catalogue().effects
    whole = twin.with_memories(baseline())
    assert set(twin.MEMORIES) < set(whole.effects)
    assert list(twin.with_memories(whole).effects) == list(whole.effects)
    electrical = twin.with_memories(KnitModel.of(effects["piezoresistance"]()))
    assert not {"stress_relaxation", "contact_relaxation", "contact_hysteresis"} & set(electrical.effects)
    assert "electrical_overshoot" in electrical.effects
    # Another law of the same mechanism counts as present.
    other = twin.with_memories(baseline().plus(effects["stress_relaxation_log"]()))
    assert "stress_relaxation" not in other.effects


def test_draws_stay_within_bounds_and_the_best_explain_the_measurement(recordings):
    short = recordings[0].between(0, 60)
    measurement = coarser(prepare(short), twin.FIT_RATE_HZ)
    best = fit(baseline(), measurement)
    drawn = twin.draws(best, 4, seed=1)
    assert drawn[0].to_dict() != drawn[1].to_dict()
    assert drawn[0].to_dict() == twin.draws(best, 4, seed=1)[0].to_dict()
    first, second = twin.plausible(baseline(), short)
    error = [np.std(measurement.residual(one)["force"][measurement.counts]) for one in (first, second)]
    assert error[1] < 1.5 * error[0]


def test_the_measurement_weighs_its_share(recordings, monkeypatch):
    seen = []

    def only_look(series, *_):
        seen.append(series)
        raise StopIteration

    monkeypatch.setattr(twin, "lessons", only_look)
    campaign = series_of(recordings[0], "force", 20.0)
    short = series_of(recordings[1].between(0, 24), "force", 20.0)
    for share, copies in ((0.0, 0), (0.5, 10), (0.3, 4)):
        with pytest.raises(StopIteration):
            twin.learned([campaign], short, "force", Options(), share=share)
        assert len(seen[-1]) - 1 == copies


def test_command_trains_from_a_model_file(recordings, tmp_path, capsys):
    recording, model, out = (tmp_path / name for name in ("r.csv", "m.json", "c.json"))
    write_recording_csv(recording, recordings[0].between(0, 40))
    words = ["train", str(recording), "--gauge-length-mm", "25", "--target", "displacement", "-o", str(out)]
    model.write_text(json.dumps(baseline().to_dict()))
    assert main([*words, "--twin", str(model)]) == 0
    assert "2 network(s)" in capsys.readouterr().out
    assert main(["score", str(out), str(recording), "--gauge-length-mm", "25"]) == 0


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
