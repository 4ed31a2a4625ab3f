"""Results show themselves: axes in and out, frames, dictionaries, HTML that quotes nothing unescaped."""

from __future__ import annotations

import copy
import json
import pickle
import re
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

import compensation
import gcode
import testbench as tb
from testbench.api.models.adding import laws_with
from testbench.campaigns.alignment import Alignment
from testbench.comparing.contribution import contribution
from testbench.knit.catalogue import load_catalogue, model_from_dict
from testbench.measurements.splitting import split
from tests.testbench.api.samples import diagnosed, fitted, relaxed

mpl.use("Agg")


def axes(count: int):
    """Axes of a figure that no window knows."""
    return list(Figure().subplots(count, 1, squeeze=False)[:, 0])


def test_a_recording_tells_and_draws_itself():
    recording = relaxed()
    assert repr(recording).startswith(f"<Recording {recording.source}: {len(recording)} samples in 9")
    assert recording._repr_html_().count("<polyline") == len(recording.channels) == 3
    on = axes(3)
    assert list(recording.plot(on)) == on
    assert [axis.get_ylabel() for axis in on] == ["strain (%)", "force (N)", "resistance (kΩ)"]
    assert on[1].lines[0].get_ydata().max() == recording["force_N"].max()
    assert on[2].lines[0].get_ydata().max() == recording["resistance_ohm"].max() / 1000
    assert list(recording.to_frame().columns) == ["time_s", *recording.channels]
    again = json.loads(json.dumps(recording.to_dict()))
    assert again["columns"]["force_N"] == recording["force_N"].tolist()
    assert again["gauge_length_mm"] == 25.0


def program() -> gcode.Program:
    """As read from its file."""
    from gcode.mach4.reader import read_program

    return read_program(gcode.generate("paper-1", seed=3, duration_s=20).program)


def compensator():
    """Fitted as quickly as one can be."""
    recording = relaxed().resampled(20.0)
    fitted_one = compensation.Compensator(method="paper")
    return fitted_one.fit(recording.conductance_S[:, None], recording["force_N"]).trained()


@pytest.mark.parametrize("make", [relaxed, program, compensator])
def test_what_holds_arrays_can_be_compared_looked_up_and_shown_in_a_line(make):
    one = make()
    assert one != copy.deepcopy(one)
    assert one in {one}
    assert re.fullmatch(r"<[A-Z].{,150}>", repr(one))


def test_a_recording_can_be_read_from_a_frame_that_it_gave():
    recording = relaxed()
    again = tb.read(recording.to_frame(), gauge_length_mm=25)
    assert np.array_equal(again["resistance_ohm"], recording["resistance_ohm"])
    assert repr(tb.read(recording.to_frame().set_index("time_s"), gauge_length_mm=25)) == repr(again)


def test_what_a_file_is_called_is_escaped_in_html():
    assert "<script>" not in replace(relaxed(), source="<script>")._repr_html_()


def test_a_fit_has_a_row_for_every_parameter_with_its_error():
    fit = fitted()
    frame = fit.parameters
    assert frame.loc["elasticity.stiffness_N", "unit"] == "N"
    assert frame.loc["elasticity.stiffness_N", "value"] == fit.model["elasticity"].stiffness_N
    assert (frame["standard_error"] >= 0).all()
    on = axes(2)
    assert list(fit.plot(on)) == on
    assert [line.get_label() for line in on[0].lines] == ["measured", "modelled"]
    assert "elasticity.stiffness_N" in fit._repr_html_()
    assert fit.errors["held_out"].keys() == {"force", "conductance"}


def test_a_copy_of_a_result_and_what_comes_out_of_a_pickle_draws_itself_as_the_result_does():
    drawn = fitted().plot(axes(2))[0].lines[1].get_ydata()
    for one in (copy.deepcopy(fitted()), pickle.loads(pickle.dumps(fitted()))):
        assert np.array_equal(one.plot(axes(2))[0].lines[1].get_ydata(), drawn)


def test_a_model_with_an_effect_more_is_another_model():
    more = fitted().model + tb.effects.StressRelaxation(fraction=0.2)
    assert more["stress_relaxation"].fraction == 0.2
    assert "stress_relaxation" not in fitted().model


def test_a_comparison_says_where_in_words_and_draws_the_residual_there():
    where = tb.compare(relaxed(), fitted())
    assert where.words == tuple(place["words"] for place in where.to_dict()["worst"])
    frame = where.to_frame()
    worst = where.to_dict()["worst"][0]
    cells = frame[(frame.channel == worst["channel"]) & (frame.coordinate == worst["coordinate"])]
    assert worst["cell"]["mean"] in set(cells["mean"])
    on = where.plot(axes(2), coordinate="strain")
    assert [axis.get_xlabel() for axis in on] == ["Strain (%)", "Strain (%)"]
    assert "noise floor" in where._repr_html_()


def test_the_zero_of_another_recording_is_not_blamed_on_the_model():
    other = relaxed(seed=2)
    shifted = replace(other, channels={**other.channels, "force_N": other["force_N"] + 1.0})
    by_result, by_model = tb.compare(shifted, fitted()), tb.compare(shifted, fitted().model)
    assert by_result.comparison.rms["force"] < 0.5 < by_model.comparison.rms["force"]


def test_a_ladder_falls_from_step_to_step_and_draws_the_floor():
    ladder = tb.add(fitted(), "stress_relaxation", relaxed(), progress=False).ladder
    assert ladder.steps == ("baseline", "+ stress_relaxation")
    frame = ladder.to_frame()
    force = frame[frame.channel == "force"]
    assert force.fall.tolist()[0] == 0
    assert force.fall.tolist()[1] > 0.3
    on = axes(2)
    assert list(ladder.plot(on)) == on
    assert [bar.get_height() for bar in on[0].patches] == force.held_out.tolist()
    assert on[0].lines[0].get_ydata()[0] == force.noise_floor.tolist()[-1]


def test_a_generated_program_shows_itself():
    made = gcode.generate("paper-1", seed=3, duration_s=60)
    (axis,) = axes(1)
    assert made.plot(axis) is axis
    assert made.to_frame()["position_mm"].iloc[0] == 0
    assert json.loads(json.dumps(made.to_dict()))["seed"] == 3
    assert "<polyline" in made._repr_html_()


@pytest.mark.parametrize("wrong", ["x", Figure(), [1, 2]])
def test_what_is_no_axes_is_refused(wrong):
    with pytest.raises(tb.UserError, match=r"axes must be Axes of Matplotlib, got (str|Figure|int)"):
        relaxed().plot(wrong)


def test_too_few_axes_are_refused():
    with pytest.raises(tb.UserError, match="needs 3 axes, one a panel, got 1"):
        relaxed().plot(axes(1))


def test_mistakes_are_one_sentence():
    with pytest.raises(tb.UserError, match=r"nowhere\.csv: no such recording"):
        tb.fit("nowhere.csv")
    with pytest.raises(tb.UserError, match="no column time_s"):
        tb.read({"force_N": [1, 2]})
    with pytest.raises(tb.UserError, match="must be a KnitModel, a result of fit or diagnose"):
        tb.compare(relaxed(), 3)  # type: ignore[arg-type]
    with pytest.raises(tb.UserError, match="must be a whole number, 1 or more, got 0"):
        tb.diagnose(relaxed(), most=0)
    with pytest.raises(tb.UserError, match=r"bounds: allowed are v_max_mm_per_s.*; got speed$"):
        tb.next_experiment([fitted(), fitted()], bounds={"speed": 3})
    with pytest.raises(tb.UserError, match=r"bounds: the gauge length is 25 mm, got 50\.0"):
        tb.next_experiment([fitted(), fitted()], bounds=tb.Bounds(gauge_length_mm=50.0))
    with pytest.raises(tb.UserError, match=r"bounds must be testbench\.Bounds or a mapping of its fields, got int"):
        tb.next_experiment([fitted(), fitted()], bounds=3)  # type: ignore[arg-type]
    with pytest.raises(tb.UserError, match=r"KnitModel: 'a' must name an effect, as .*, got int"):
        tb.KnitModel({"a": 1})  # type: ignore[dict-item]
    with pytest.raises(tb.UserError, match=r"Instruments: clock\.rate_hz: .* or equal to 0\.01, got 0"):
        tb.Instruments(clock={"rate_hz": 0})  # type: ignore[arg-type]
    with pytest.raises(tb.UserError, match="duration_s must be a number, got '3'"):
        tb.next_experiment([fitted(), fitted()], bounds={"duration_s": "3"})  # type: ignore[dict-item]
    with pytest.raises(tb.UserError, match=r"bounds: the gauge length is 25 mm, got 50\.0"):
        tb.next_experiment([fitted(), fitted()], bounds={"gauge_length_mm": 50.0})
    with pytest.raises(tb.UserError, match="give two or more rival models, got 1"):
        tb.next_experiment([fitted()])
    with pytest.raises(tb.UserError, match="give two or more rival models, got 3"):
        tb.next_experiment(3)  # type: ignore[arg-type]
    with pytest.raises(tb.UserError, match="must be a Recording, a CSV or a campaign folder, got dict"):
        tb.fit({"force_N": [1, 2]})  # type: ignore[arg-type]
    with pytest.raises(tb.UserError, match=r"no such model\.json, and no preset; presets are lycra, pes"):
        tb.simulate("pess", gcode.generate("paper-1", seed=1, duration_s=20))
    with pytest.raises(tb.UserError, match="has no history"):
        tb.ladder(tb.baseline())
    with pytest.raises(tb.UserError, match="preset must be one of"):
        gcode.generate("paper-9", seed=1)
    with pytest.raises(tb.UserError, match="duration_s"):
        gcode.generate("paper-1", seed=1, duration_s=-3)
    assert issubclass(tb.UserError, ValueError)


def test_an_effect_of_ones_own_takes_part(tmp_path):
    class Loose(tb.Effect):
        """The force grows with the square of the strain more than it should."""

        name = "loose"
        stage = tb.Stage.MECHANICS
        reads, writes = ("strain", "force_N"), ("force_N",)
        strength = "gain_N"

        gain_N: float = tb.parameter(0.1, unit="N", low=0, high=10, doc="force at a strain of one")

        def apply(self, signals, dt_s):
            return {"force_N": signals["force_N"] + self.gain_N * signals["strain"] ** 2}

    fit = tb.fit(relaxed(), model=fitted().model + Loose(gain_N=1.0), effects=[Loose], progress=False)
    assert "loose.gain_N" in fit.parameters.index
    fit.save(tmp_path / "model.json")
    assert tb.ladder(tmp_path / "model.json", effects=[Loose]).steps == ("given model",)
    with pytest.raises(tb.UserError, match="an effect called stress_relaxation already"):
        tb.fit(relaxed(), effects=[tb.effects.StressRelaxation])


def test_what_a_result_gives_away_is_not_the_result_itself():
    """Somebody who works on with the numbers does not change the fit."""
    before = json.dumps(fitted().to_dict())
    fitted().errors["held_out"]["force"] = 0.0
    fitted().to_dict()["history"][0]["errors"]["held_out"].clear()
    fitted().ladder.to_dict()[0]["errors"]["calibration"].clear()
    fitted().to_dict()["fit"]["parameters"].clear()
    assert json.dumps(fitted().to_dict()) == before
    made = gcode.generate("paper-1", seed=1, duration_s=20)
    with pytest.raises(AttributeError):
        gcode.check(made.program, gcode.Limits(v_max_mm_per_s=0.1)).problems.clear()


def test_a_recording_lists_its_channels_as_a_frame_its_columns():
    assert list(relaxed()) == list(relaxed().channels)
    assert len(fitted().model) == len(list(fitted().model))


def test_the_picture_of_a_diagnosis_and_its_table_have_one_order():
    """Most mechanisms have the probability of no evidence, all the same: the table ranks them by their evidence."""
    d = diagnosed()
    told = [name for name in d.probabilities if name not in ("nothing", "unknown")]
    ranked = d.to_frame()
    assert ranked.probability.duplicated().any()
    assert told == ranked.sort_values("probability", ascending=False, kind="stable").effect.tolist()


def test_a_diagnosis_has_probabilities_a_picture_and_a_ladder():
    d = diagnosed()
    assert d.effect == "stress_relaxation"
    assert sum(d.probabilities.values()) == pytest.approx(1)
    frame = d.to_frame()
    assert frame.effect[0] == "stress_relaxation"
    assert frame.probability[0] == d.probabilities["stress_relaxation"]
    left = frame[["held_out_error_left_low", "held_out_error_left", "held_out_error_left_high"]].to_numpy()
    assert left[0, 0] < left[0, 1] < left[0, 2] < 1, "the right mechanism takes most of the error away"
    (axis,) = axes(1)
    assert d.plot(axis) is axis
    assert axis.get_yticklabels()[0].get_text().startswith("stress relaxation (")
    assert d.ladder.steps[0] == "baseline"
    assert any(effect.name.startswith("stress_relaxation") for effect in d.model.effects.values())
    assert d.words in d._repr_html_().replace("&gt;", ">").replace("&lt;", "<")


def test_a_candidate_shows_what_it_would_add_where_the_model_was_judged():
    found = tb.contribution(diagnosed(), "stress_relaxation", relaxed())
    frame = found.to_frame()
    assert list(frame.columns) == [
        "time_s",
        "force_residual_N",
        "force_added_N",
        "conductance_residual_ln_S",
        "conductance_added_ln_S",
    ]
    assert frame.time_s.min() >= 60, "the last third of 90 s"
    before = model_from_dict(diagnosed().to_dict()["history"][-2]["model"], load_catalogue(), "history")
    held = split(relaxed())[1]
    base = contribution(before, diagnosed().diagnosis.ranking[0].start, held)
    assert np.array_equal(frame.force_residual_N, base.residual["force"])
    assert np.array_equal(frame.conductance_added_ln_S, base.added["conductance"])
    assert np.array_equal(found.ln_S, held.measured["conductance"][held.counts])
    assert len(found.plot(axes(2))) == 2
    with pytest.raises(tb.UserError, match="has no law or effect 'nothing'; it ranks stress_relaxation"):
        tb.contribution(diagnosed(), "nothing", relaxed())


def test_a_contribution_is_that_to_the_recording_that_was_diagnosed():
    for other in (relaxed(2), tb.read(relaxed().to_frame()[["time_s", "displacement_mm", "force_N"]], 25)):
        with pytest.raises(tb.UserError, match=r"judged on other samples: their noise floor is force .* diagnosed"):
            tb.contribution(diagnosed(), "stress_relaxation", other)
    untold = json.loads(json.dumps(diagnosed().to_dict()))
    del untold["history"]
    with pytest.raises(tb.UserError, match="contribution: the diagnosis keeps no models; diagnose anew"):
        tb.contribution(untold, "stress_relaxation", relaxed())


def test_what_the_base_needs_goes_in_before_the_candidate():
    diagnosis = {"other_laws": ["elasticity_ogden"], "base_misfits": ["drift_shape"]}
    wanted = ["elasticity_ogden", "drift_shape", "stress_relaxation"]
    assert laws_with(diagnosis, "stress_relaxation", fitted()) == wanted
    better = fitted().model + tb.effects.StressRelaxation()
    assert laws_with(diagnosis, "stress_relaxation", better) == wanted[:2]


def test_every_result_shows_itself_in_a_notebook_and_can_be_kept_as_json():
    results = [getattr(tb, name) for name in tb.__all__ if name.endswith(("Result", "Case", "Experiment", "Ladder"))]
    assert len(results) == 16
    without_a_picture = {tb.DatasetResult, tb.VerifyResult, tb.ReportResult, tb.KnitModel, gcode.CheckResult}
    for result in (*results, tb.Recording, tb.KnitModel, gcode.Made, gcode.Trajectory, gcode.CheckResult):
        assert callable(getattr(result, "_repr_html_", None)), result
        assert callable(getattr(result, "to_dict", None)), result
        assert callable(getattr(result, "to_frame", None)) or result is tb.ReportResult, result
        assert callable(getattr(result, "plot", None)) or result in without_a_picture, result


def test_what_was_run_verified_and_gathered_is_shown_with_its_samples_and_problems(tmp_path):
    ran = tb.run("pes", gcode.generate("paper-1", seed=1, duration_s=20), tmp_path / "knit")
    assert ran._repr_html_().count("<polyline") == 3
    assert len(ran.to_frame()) == ran.status.samples
    assert len(ran.plot(axes(3))) == 3
    assert "1 campaign, intact" in tb.verify(tmp_path / "knit")._repr_html_()
    (tmp_path / "knit" / "recording.csv").write_text("time_s,force_N")
    assert "recording.csv" in tb.verify(tmp_path / "knit")._repr_html_()


def test_a_plan_that_began_first_is_said_to_have_begun_before_the_recording():
    aligned = [
        tb.AlignmentResult(Alignment(delay_s, drift_ppm, 0.0, 1.0, 0.004), relaxed(), Path("program.tap"))
        for delay_s, drift_ppm in ((-0.25, -52.0), (0.25, 52.0), (-0.0001, -0.1))
    ]
    assert [one.words[0] for one in aligned] == [
        "the plan began 0.250 s before the recording; its clock loses 5 ms over the recording (52 ppm)",
        "the plan began 0.250 s after the recording; its clock gains 5 ms over the recording (52 ppm)",
        "the plan began together with the recording; their clocks run alike",
    ]


def test_a_hidden_case_shows_its_recordings_and_not_its_truth(tmp_path):
    case = tb.hide("stress_relaxation", tmp_path / "case", seed=1, minutes=2)
    assert case._repr_html_().count("<polyline") == 6
    assert len(case.plot(axes(3))) == 3
    samples = case.to_frame()["recording"].value_counts()
    assert samples.to_dict() == {"calibration": len(case.calibration), "held_out": len(case.held_out)}
    assert "stress_relaxation" not in case._repr_html_() + json.dumps(case.to_dict())


def test_a_check_and_what_was_played_show_themselves():
    made = gcode.generate("paper-1", seed=1, duration_s=20)
    refused = gcode.check(made.program, gcode.Limits(v_max_mm_per_s=0.1))
    assert list(refused.to_frame()["line"]) == [problem.line for problem in refused.problems]
    assert str(refused.problems[0]) in refused._repr_html_()
    played = gcode.play(made)
    assert len(played.to_frame()) == len(played.to_dict()["time_s"]) == len(played.time_s)
    assert "<polyline" in played._repr_html_()
    assert played.plot(axes(1)[0]).get_ylabel() == "position (mm)"


def test_a_program_is_taken_in_every_form_and_nothing_else(tmp_path):
    made = gcode.generate("paper-1", seed=1, duration_s=20)
    made.write(tmp_path)
    forms = (
        made,
        made.program,
        tmp_path / "program.tap",
        str(tmp_path / "program.tap"),
        gcode.read(tmp_path / "program.tap"),
    )
    for form in forms:
        assert gcode.check(form).ok
        assert len(gcode.play(form).time_s) == len(gcode.play(made).time_s)
    for function in (gcode.check, gcode.play):
        with pytest.raises(tb.UserError, match="or what `generate` made, got int"):
            function(7)


def test_what_a_fit_and_a_diagnosis_say_stays():
    fit, found = fitted(), diagnosed()
    some = [fit.file.fit, fit.file.fit["parameters"], fit.file.history[0], found.diagnosis.probabilities]
    some += [found.diagnosis.error_before, found.diagnosis.noise_floor]
    some += [fit.held_out.measured, fit.calibration.signals]
    for mapping in some:
        with pytest.raises(TypeError, match="not changed in place"):
            mapping["nothing"] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        fit.held_out.measured["force"][:] = 0.0
    found.to_dict()["found"][0]["effect"] = "nothing"
    assert found.diagnosis.found[0].effect != "nothing"
