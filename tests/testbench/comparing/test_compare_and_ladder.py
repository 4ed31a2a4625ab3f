"""Compare names planted misfits; the ladder adds, takes back, and points out what idles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.comparing.cell import Cell
from testbench.comparing.compare import Comparison, Place, _cell, compare, distinct, residual_maps
from testbench.comparing.ladder import as_a_step, fitted_file, idle_effects, undo
from testbench.comparing.model_errors import noise_floors
from testbench.comparing.residual_coordinates import coordinates
from testbench.comparing.tables import comparison_table
from testbench.diagnosis.adding import add_effect
from testbench.measurements.preparing import prepare
from testbench.measurements.splitting import split
from testbench.results.model_file import load_model_file
from tests.testbench.builders import CATALOGUE, record, truth


def with_force(recording, force):
    return type(recording)(
        recording.time_s, {**recording.channels, "force_N": force}, recording.gauge_length_mm, recording.source
    )


def test_a_relaxing_force_is_named_where_it_sits():
    """Each stretch leaves a force that relaxes in 5 s: the model without it is too low soon after a reversal."""
    plain = record(truth(), strain=lambda t: 0.15 * (1 - np.sign(np.sin(2 * np.pi * t / 40)) * np.minimum(1, t)))
    since = coordinates(prepare(plain))["since_reversal_s"]
    since = np.interp(plain.time_s, np.arange(len(since)) / 20, since)
    stretched = plain.strain > 0.2
    force = plain["force_N"] + np.where(stretched, 0.3 * np.exp(-since / 5), 0)
    result = compare(truth(), prepare(with_force(plain, force)))
    worst = result.worst[0]
    assert worst.channel == "force"
    assert worst.cell.mean > 0
    assert "modelled force" in worst.words
    assert "too low" in worst.words
    soon = [p for p in result.worst if p.coordinate in ("since_reversal_s", "since_hold_s")]
    assert soon
    assert soon[0].cell.high < 12


def test_a_misfit_over_strain_is_named():
    plain = record(truth())
    force = plain["force_N"] + np.where(plain.strain > 0.22, 0.4, 0.0)
    worst = compare(truth(), prepare(with_force(plain, force))).worst
    strain = next(place for place in worst if place.coordinate == "strain")
    assert strain.cell.low >= 0.2
    assert "too low between" in strain.words


def test_a_right_model_has_no_bad_places():
    result = compare(truth(), prepare(record(truth())))
    assert result.rms["force"] == pytest.approx(result.noise_floor["force"], rel=0.05)
    cells = [cell for maps in result.maps.values() for found in maps.values() for cell in found]
    assert sum(abs(cell.t) > 3 for cell in cells) <= 1 < len(cells) / 50
    assert not result.worst


def test_a_hum_between_the_points_of_the_grid_is_not_called_a_few_peaks():
    plain = record(truth(), rate_hz=500.0)
    hum = 20 * noise_floors(prepare(plain))["force"] * np.sin(2 * np.pi * 50.0 * plain.time_s)
    (said,) = compare(truth(), prepare(with_force(plain, plain["force_N"] + hum))).places
    assert said == "the error of the force comes and goes too quickly for any effect: a hum, or coloured noise"


def test_maps_hold_every_sample_once_and_their_means_make_up_the_residual():
    measurement = prepare(record(truth()))
    where = {name: values[measurement.counts] for name, values in coordinates(measurement).items()}
    residual = np.random.default_rng(0).normal(0.3, 1.0, int(measurement.counts.sum()))
    maps = residual_maps(residual, where)
    for coordinate in ("strain_rate", "elapsed_s", "cycle"):
        cells = maps[coordinate]
        assert sum(cell.share for cell in cells) == pytest.approx(1.0, abs=0.02)
        assert sum(cell.share * cell.mean for cell in cells) == pytest.approx(residual.mean(), abs=0.02)
        assert all(cell.standard_error > 0 for cell in cells)


def test_blocks_are_of_time_however_rarely_a_hold_was_sampled():
    """One sample in 5 s: 20 s of them are 4, and of 500 s there are 25 blocks."""
    where = {name: np.zeros(100) for name in ("strain", "direction", "since_hold_s")}
    where["elapsed_s"] = 5.0 * np.arange(100)
    residual = np.random.default_rng(0).normal(0.0, 1.0, 100)
    (cell,) = residual_maps(residual, {**where, "cycle": np.minimum(np.arange(100.0), 1.0)})["cycle"]
    assert cell.standard_error == pytest.approx(1 / 25**0.5, rel=0.25)


@pytest.fixture(scope="module")
def parts():
    model = truth().plus(CATALOGUE["stress_relaxation"]().replaced(fraction=0.2, tau_s=15))
    return split(record(model, 360, 12.0, seed=1), record(model, 360, 12.0, seed=2))


@pytest.fixture(scope="module")
def ladder(parts):
    base = fitted_file(truth(), *parts, "baseline")
    return base, add_effect(base, "stress_relaxation", *parts, CATALOGUE)


def test_adding_the_hidden_effect_reaches_the_noise(ladder):
    before, after = (file.history[-1] for file in ladder)
    floor = after["noise_floor"]["force"]
    assert before["errors"]["held_out"]["force"] > 2 * floor
    assert after["errors"]["held_out"]["force"] < 1.2 * floor
    assert [step["step"] for step in ladder[1].history] == ["baseline", "+ stress_relaxation"]
    assert ladder[1].model["stress_relaxation"].tau_s == pytest.approx(15, rel=0.2)


def test_undo_is_the_step_before_and_stops_at_the_first(ladder, tmp_path):
    base, added = ladder
    added.save(tmp_path / "model.json")
    back = undo(load_model_file(tmp_path / "model.json", CATALOGUE), CATALOGUE)
    assert back.model.to_dict() == base.model.to_dict()
    assert back.fit["parameters"] == base.fit["parameters"] != {}, "with the errors of its parameters"
    assert back.history == base.history
    with pytest.raises(UserError, match="nothing to undo"):
        undo(back, CATALOGUE)


def test_undo_names_the_recordings_that_the_step_below_was_fitted_and_judged_on(ladder, parts):
    """Else the model below counts as fitted on what only the step above it was."""
    other = replace(parts[0], recording=replace(parts[0].recording, source="another.csv"))
    above = as_a_step(ladder[0].model, ladder[0].fit, ladder[0], "+ more", other, other)
    assert (above.fitted_on, above.held_out) == ("another.csv", "another.csv")
    back = undo(above, CATALOGUE)
    assert (back.fitted_on, back.held_out) == (ladder[0].fitted_on, ladder[0].held_out)


def test_an_effect_that_does_nothing_is_pointed_out_and_one_that_pays_is_not(parts, ladder):
    both = add_effect(ladder[1], "load_cell_creep", *parts, CATALOGUE)
    assert idle_effects(both, *parts, {"load_cell_creep", "stress_relaxation"}) == ["load_cell_creep"]


def test_a_model_file_comes_back_as_it_was(ladder, tmp_path):
    path = tmp_path / "model.json"
    ladder[1].save(path)
    again = load_model_file(path, CATALOGUE)
    assert again.model.to_dict() == ladder[1].model.to_dict()
    assert [dict(step) for step in again.history] == [dict(step) for step in ladder[1].history]
    assert again.fit == ladder[1].fit
    assert again.gauge_length_mm == 25.0


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("{}", "not a knitbench model"),
        ('{"format": "knitbench-model", "version": 99, "effects": []}', "version 99"),
        (
            '{"format": "knitbench-model", "version": 1, '
            '"effects": [{"name": "x", "effect": "no_such", "parameters": {}}]}',
            "no_such",
        ),
    ],
)
def test_a_file_that_is_no_model_is_refused(tmp_path, text, match):
    path = tmp_path / "model.json"
    path.write_text(text)
    with pytest.raises(UserError, match=match):
        load_model_file(path, CATALOGUE)


def test_a_block_that_holds_nearly_all_samples_does_not_prove_a_place():
    """The mean of 20 s says little of the next: 93 of 100 such cells stood out by more than three errors."""
    rng = np.random.default_rng(4)
    block = np.repeat([0, 1, 2], [100, 2, 2])
    ts = []
    for _ in range(200):
        values = rng.normal(size=3)[block] + 0.1 * rng.normal(size=len(block))
        (cell,) = _cell(values, block, (0.0, 1.0, 0), 1000)
        ts.append(abs(cell.t))
    assert np.mean(np.array(ts) > 3) < 0.15, "as often as a t of two degrees of freedom, 0.1"


def test_each_channel_that_fails_is_told_of_where_a_place_is_known_and_where_none_is():
    """The conductance was wrong by a hundred times its noise, and the force alone was named."""
    spot = Cell(0.1, 0.2, 0, 0.1, 0.01, 0.1)
    found = [
        Place(channel, name, spot, share, f"{channel} over {name}")
        for channel, name, share in (
            ("force", "strain", 0.9),
            ("force", "cycle", 0.8),
            ("force", "strain", 0.7),
            ("force", "elapsed_s", 0.6),
            ("conductance", "cycle", 0.1),
        )
    ]
    worst = distinct(found)
    assert [place.words for place in worst] == ["force over strain", "force over cycle", "conductance over cycle"]
    sizes = [dict.fromkeys(("force", "conductance"), size) for size in (1.0, 0.01, 0.0)]
    both, one = Comparison(*sizes, {}, tuple(worst)), Comparison(*sizes, {}, tuple(worst[:2]))
    assert len(both.places) == 3
    assert one.places[2] == comparison_table(one).splitlines()[-1]
    assert one.places[2].startswith("the error of the conductance is spread out")
