"""Every figure is valid Plotly, keeps the peaks of its data, and can be drawn without a browser."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import plotly.graph_objects
import pytest

import tests.testbench.report.samples as samples
from compensation.paper.published import COMPENSATED
from gcode.support.figures import rows_to_draw
from testbench.diagnosis.verdict import with_probability
from testbench.measurements.preparing import prepare
from testbench.recordings.recording import Recording
from testbench.report import overlays, sections, style, words
from testbench.report.downsample import window
from testbench.report.figures import (
    comparison_figures,
    compensator_figures,
    diagnosis_figures,
    experiment_figures,
    ladder_figures,
    live_figures,
    motion_figures,
    recording_figures,
    residual_figures,
)
from testbench.report.story import glance_facts
from testbench.report.style import Figure
from testbench.report.writing.static import draw, draw_on, write_figure


def residual_and_contribution():
    both = samples.overlay()
    residual = {channel: both.residual(channel, "baseline") for channel in both.measured}
    contribution = {
        channel: both.modelled["+ creep"][channel] - both.modelled["baseline"][channel] for channel in both.measured
    }
    return both.time_s, residual, contribution


TWO_S, NINE_S = (np.arange(2.0), np.ones(2)), (np.arange(9.0), np.ones(9))
FORCE_AND_COMPENSATED = live_figures.LiveChannel(
    "Force (N)",
    "#0072B2",
    NINE_S,
    TWO_S,
    beside=live_figures.LiveChannel("Compensated force (N)", "#D55E00", NINE_S, TWO_S),
)
FIGURES: dict[str, Callable[[], Figure | None]] = {
    "time series": lambda: recording_figures.time_series(samples.recording(temperature=True)),
    "time series, a stretch": lambda: recording_figures.time_series(samples.recording(), 20.0, 40.0),
    "loops": lambda: recording_figures.hysteresis_loops(samples.recording()),
    "loops without force": lambda: recording_figures.hysteresis_loops(samples.recording(force=False)),
    "distributions": lambda: recording_figures.distributions(samples.recording(resistance=False)),
    "overlay": lambda: comparison_figures.overlay(samples.overlay()),
    "overlay, a stretch": lambda: comparison_figures.overlay(samples.overlay(), 20.0, 40.0),
    "modelled loops": lambda: comparison_figures.modelled_loops(samples.overlay()),
    "heat maps": lambda: residual_figures.heat_maps(samples.overlay()),
    "profiles": lambda: residual_figures.profiles(samples.comparison().maps["force"], "force"),
    "ladder": lambda: ladder_figures.ladder(samples.steps(), current=0),
    "at a glance": lambda: ladder_figures.at_a_glance(samples.overlay(), samples.steps(), (20.0, 60.0)),
    "scores": lambda: compensator_figures.before_and_after(
        samples.score()["recordings"], ["pes-T", "pes-A"], "force"
    ),
    "score over time": lambda: compensator_figures.over_time(samples.score()["recordings"][1], "force"),
    "score scatter": lambda: compensator_figures.scatter(samples.score()["recordings"][1], "displacement"),
    "candidates": lambda: diagnosis_figures.candidates(samples.diagnosis()),
    "dependence": lambda: diagnosis_figures.dependence(samples.diagnosis()),
    "prediction": lambda: diagnosis_figures.prediction(*residual_and_contribution(), 20.0, 40.0),
    "slope": lambda: diagnosis_figures.slope(*residual_and_contribution()[1:]),
    "alignment": lambda: motion_figures.alignment(np.arange(90) / 9, np.ones(90), np.linspace(0, 1, 90), 2.0, 5.0),
    "experiment": lambda: experiment_figures.of_file(samples.experiment(), np.arange(3.0), np.arange(3.0)),
    "motion": lambda: motion_figures.motion(np.arange(400) / 20, np.sin(np.arange(400) / 20), 2.0, 3.0),
    "live": lambda: live_figures.live(
        [
            live_figures.LiveChannel(
                "Force (N)", "#0072B2", (np.arange(9.0), np.ones(9)), (np.arange(4.0), np.ones(4)), 2.0
            )
        ]
    ),
    "live with a compensator": lambda: live_figures.live([FORCE_AND_COMPENSATED]),
    "live before the first sample": lambda: live_figures.live([]),
}


def test_a_map_of_a_short_recording_has_fewer_cells_and_no_empty_page() -> None:
    t = np.arange(300) / 10
    strain = 0.1 * (1 - np.cos(1.3 * t))
    short = comparison_figures.Overlay(
        t, strain, {"force": 20 * strain}, {"model": {"force": 18 * strain}}, {"force": 0.01}
    )
    (trace,) = residual_figures.heat_maps(short)["data"]
    assert np.isfinite(np.array(trace["z"], dtype=float)).sum() >= 8


@pytest.mark.parametrize("name", FIGURES)
def test_plotly_accepts_every_property(name: str) -> None:
    figure = FIGURES[name]()
    assert figure is not None
    assert len(plotly.graph_objects.Figure(figure).data) == len(figure["data"])


@pytest.mark.parametrize("name", FIGURES)
def test_matplotlib_draws_as_many_axes_as_the_layout_names(name: str) -> None:
    figure = FIGURES[name]()
    assert figure is not None
    y_axes = [key for key in figure["layout"] if key.startswith("yaxis")]
    drawn = draw(figure).axes
    bars = sum(
        1 for trace in figure["data"] if trace["type"] == "heatmap" or trace.get("marker", {}).get("showscale")
    )
    assert len(drawn) == len(y_axes) + bars


def test_one_sample_spike_survives_downsampling() -> None:
    values = np.sin(np.linspace(0, 20, 100_000))
    values[61_803] = 9.0
    rows = rows_to_draw(values, 1000)
    assert len(rows) <= 1002
    assert values[rows].max() == 9.0
    assert rows[0] == 0
    assert rows[-1] == 99_999


def test_a_window_reaches_one_sample_beyond_each_edge() -> None:
    time_s = np.arange(10.0)
    assert window(time_s, 2.5, 4.5) == slice(2, 6)
    assert window(time_s, None, None) == slice(0, 10)


def test_zooming_draws_the_stretch_in_full() -> None:
    source = samples.recording(60_000)
    figure = recording_figures.time_series(source, 100.0, 130.0)
    x = figure["data"][0]["x"]
    inside = (source.time_s >= 100) & (source.time_s <= 130)
    assert np.count_nonzero((x >= 100) & (x <= 130)) == np.count_nonzero(inside)


def test_a_time_series_is_broken_where_nothing_was_recorded():
    whole = samples.recording()
    kept = (whole.time_s < 20.0) | (whole.time_s > 40.0)
    gappy = replace(
        whole, time_s=whole.time_s[kept], channels={name: one[kept] for name, one in whole.channels.items()}
    )
    for trace in recording_figures.time_series(gappy)["data"]:
        assert [20 < x < 40 for x, y in zip(trace["x"], trace["y"], strict=True) if np.isnan(y)] == [True]


def with_a_gap() -> comparison_figures.Overlay:
    """The overlay of the samples with nothing from 20 to 40 s."""
    whole = samples.overlay()
    return whole.within((whole.time_s < 20.0) | (whole.time_s > 40.0))


def prediction_with_a_gap() -> Figure:
    both = with_a_gap()
    return diagnosis_figures.prediction(both.time_s, both.measured, both.modelled["baseline"])


def alignment_with_a_gap() -> Figure:
    both = with_a_gap()
    return motion_figures.alignment(both.time_s, both.strain, both.strain)


@pytest.mark.parametrize(
    "drawn",
    [
        lambda: comparison_figures.overlay(with_a_gap()),
        lambda: ladder_figures.at_a_glance(with_a_gap(), samples.steps(), (10.0, 50.0)),
        prediction_with_a_gap,
        alignment_with_a_gap,
    ],
)
def test_every_line_over_time_is_broken_where_nothing_was_recorded(drawn):
    lines = [one for one in drawn()["data"] if len(one["x"]) > 10]
    assert len(lines) > 2
    for one in lines:
        assert [20 < x < 40 for x, y in zip(one["x"], one["y"], strict=True) if np.isnan(y)] == [True]


def test_loops_are_broken_where_nothing_was_recorded():
    both = with_a_gap()
    short = both.within(both.time_s < 60.0)  # one stretch
    for one in comparison_figures.modelled_loops(short)["data"]:
        assert np.isnan(one["y"]).sum() == np.isnan(one["x"]).sum() == 1
    rows = recording_figures.unbroken(np.arange(0, 6, 2), np.array([0.0, 1, 2, 9, 10, 11]), [(2.0, 9.0)])
    assert rows.tolist() == [0, 2, -1, 4]


def test_what_was_made_up_in_a_gap_is_not_shown():
    source = samples.recording()
    kept = (source.time_s < 20.0) | (source.time_s > 40.0)
    channels = {name: values[kept] for name, values in source.channels.items()}
    measurement = prepare(replace(source, time_s=source.time_s[kept] + 100, channels=channels))
    both = overlays.overlay_of(measurement, {})
    assert ((both.time_s > 21) & (both.time_s < 39)).any()
    shown = overlays.as_read(both, measurement)
    assert [20 < middle < 40 for middle in np.mean(shown.gaps, axis=1)] == [True]
    assert not ((shown.time_s > 21) & (shown.time_s < 39)).any()


def test_a_recording_of_motion_alone_has_no_loops() -> None:
    assert recording_figures.hysteresis_loops(samples.recording(force=False, resistance=False)) is None


def test_values_that_differ_by_rounding_alone_are_drawn_beside_each_other() -> None:
    time_s = np.arange(3.0) / 10
    steady = Recording(time_s, {"displacement_mm": np.array([0.1, 0.2, 0.3]), "force_N": np.ones(3)}, 25.0, "steady")
    _, speed, force = recording_figures.distributions(steady)["data"]
    for trace in (speed, force):
        bars = np.flatnonzero(trace["y"])
        assert 1 <= bars.size <= 2
        assert np.ptp(bars) <= 1


def test_distribution_shares_add_up_to_the_whole_time() -> None:
    shares = [trace["y"].sum() for trace in recording_figures.distributions(samples.recording())["data"]]
    assert shares == pytest.approx([100] * 4)


@pytest.mark.parametrize(("siemens", "unit"), [(2.0, "S"), (5e-3, "mS"), (4e-6, "µS"), (2e-9, "nS")])
def test_conductance_is_shown_in_a_readable_unit(siemens: float, unit: str) -> None:
    assert recording_figures.conductance_scale(np.full(5, siemens))[1] == unit


def test_the_window_to_look_at_is_where_the_first_model_is_worst() -> None:
    both = samples.overlay()
    both.modelled["baseline"]["force"][1000:1100] += 5.0
    start_s, end_s = comparison_figures.busiest_window(both, 10.0)
    assert start_s <= both.time_s[1100]
    assert end_s >= both.time_s[1000]


def test_samples_that_lie_far_apart_are_seen_as_dots(tmp_path: Path) -> None:
    """Of a relaxation of 30 min that was sampled ever more rarely the last 23 min stayed blank."""
    time_s = np.concatenate([np.arange(0, 60, 0.1), np.arange(60, 120, 5.0)])
    rare = Recording(time_s, {"displacement_mm": np.ones(len(time_s)), "force_N": 2 / (1 + time_s)}, 25.0, "rare.csv")
    figure = recording_figures.time_series(rare)
    force = figure["data"][1]
    dots = force["marker"]["size"] > 0
    assert force["x"][dots].tolist() == time_s[-11:].tolist()
    write_figure(figure, tmp_path / "rare.png")
    assert "marker" not in recording_figures.time_series(samples.recording())["data"][1]


def test_a_day_of_a_hold_is_told_in_hours_and_its_noise_drawn_as_a_line() -> None:
    """It lasted 1444.0 min at 0.2 Hz (0.25 Hz), and its thumbnail was noise from bottom to top."""
    time_s = np.arange(21_600) * 4.0
    force_N = 3 + np.random.default_rng(1).normal(0, 0.01, len(time_s))
    force_N[:100] = 0
    hold = Recording(time_s, {"displacement_mm": 10.0 * (time_s > 400), "force_N": force_N}, 25.0, "hold.csv")
    told = dict(recording_figures.summary(hold))
    assert (told["Duration"], told["Samples"]) == ("24.0 h", "21 600 at 0.25 Hz")
    force = re.findall(r'points="([^"]*)"', recording_figures.thumbnail(hold))[1]
    heights = [float(point.split(",")[1]) for point in force.split()]
    assert max(heights) - min(heights) < 3


def test_a_loop_keeps_the_peak_of_a_quick_pull_before_a_day_of_a_hold() -> None:
    time_s = np.arange(21_600) * 4.0
    pull = np.minimum(time_s / 300, 1.0)
    force_N = 4 * pull * np.exp(-np.maximum(time_s - 300, 0) / 600)
    hold = Recording(time_s, {"displacement_mm": 10.0 * pull, "force_N": force_N}, 25.0, "hold.csv")
    drawn = recording_figures.hysteresis_loops(hold)
    assert drawn
    (loop,) = drawn["data"]
    assert len(loop["y"]) < 2000
    assert loop["y"].max() == force_N.max()


def test_thumbnail_is_one_small_svg() -> None:
    picture = recording_figures.thumbnail(samples.recording())
    assert picture.startswith("<svg")
    assert picture.count("<polyline") == 2
    assert "<path" in picture
    assert len(picture) < 16_000


def test_loops_are_whole_stretches_from_the_first_minute_to_the_last() -> None:
    source = samples.recording(30_000)
    parts = recording_figures.stretches(source.time_s, source.strain)
    assert len(parts) == 6
    assert parts[0].start == 0
    assert parts[-1].stop == len(source)
    for part in parts:
        assert np.ptp(source.time_s[part]) == pytest.approx(30, abs=0.2)
    assert recording_figures.stretches(source.time_s[:100], source.strain[:100]) == [slice(0, 100)]
    assert recording_figures.loops_caption(source) == (
        "Loops of six half minutes, the first dark, the last light: a shift along the colours is drift."
    )
    # A motion this slow, and samples this rare, have no loop in half a minute.
    in_words = recording_figures.stretches_in_words
    assert in_words(source.time_s, source.strain, 3) == "three half minutes"
    assert in_words(60 * source.time_s, np.sin(60 * source.time_s)) == "six stretches of 1.5 min"
    assert in_words(20 * source.time_s, np.sin(source.time_s)) == "six stretches of 2.1 min"


def test_the_loops_of_a_short_recording_are_one_whole_drawn_at_full_detail() -> None:
    source = samples.recording()
    drawn = recording_figures.hysteresis_loops(source)
    assert recording_figures.loops_caption(source) == "Loops of the whole recording."
    assert [len(trace["x"]) for trace in drawn["data"]] == [len(source)] * 3
    assert not any(trace["showlegend"] for trace in drawn["data"]), "there is no other stretch to be told from"


def test_a_short_recording_lasts_seconds() -> None:
    assert recording_figures.summary(samples.recording(300))[0] == ("Duration", "14.9 s")
    assert recording_figures.summary(samples.recording())[0] == ("Duration", "2.5 min")


def test_the_ends_of_a_compensated_recording_are_as_long_as_they_are_said_to_be() -> None:
    row = {"zooms": [{"time_s": [0.0, 59.95]}]}
    assert compensator_figures.ends_in_words(row) == "the first and the last minute"
    assert compensator_figures.ends_in_words({"zooms": [{"time_s": [0.0, 16.63]}]}) == "the first and the last 17 s"


def test_an_effect_that_is_there_lies_on_the_one_to_one_line() -> None:
    dots, line_ = diagnosis_figures.slope(*residual_and_contribution()[1:])["data"][:2]
    assert np.polyfit(dots["x"], dots["y"], 1)[0] == pytest.approx(1.0, abs=0.02)
    assert list(line_["x"]) == list(line_["y"])


def test_the_named_effect_and_those_tied_with_it_stand_out() -> None:
    found = samples.diagnosis()
    colours = diagnosis_figures.candidates(found)["data"][0]["marker"]["color"]
    assert colours[0] == colours[1]
    found["ranking"][1]["tied_for_first"] = False
    colours = diagnosis_figures.candidates(found)["data"][0]["marker"]["color"]
    assert colours[0] != colours[1]
    unknown = diagnosis_figures.candidates(samples.diagnosis("unknown"))["data"][0]["marker"]["color"]
    assert len(set(unknown)) == 1


def test_nothing_left_to_depend_on_is_no_figure() -> None:
    assert diagnosis_figures.dependence({"depends_on": []}) is None


@pytest.mark.parametrize(
    ("verdict", "sentence"),
    [
        (
            "missing",
            "Missing: stress relaxation (61 %), hardly told from load cell creep (36 %). 7 % of the error above the "
            "noise is left. The held-out error of the force goes from 0.120 to 0.0110 N, that of the conductance "
            "from 0.0310 to 0.00240 ln S.",
        ),
        (
            "unknown",
            "Unknown (88 %): something is missing that no effect of the catalogue explains. What is left depends "
            "most on this: force on elapsed time (70 % of it). The nearest is stress relaxation, which would leave "
            "60 % of the error above the noise.",
        ),
        ("nothing_missing", "Nothing is missing that these recordings could show (92 %)."),
    ],
)
def test_a_verdict_is_a_sentence(verdict: str, sentence: str) -> None:
    assert words.verdict_in_words(samples.diagnosis(verdict)) == sentence


def test_nothing_missing_does_not_hide_an_error_far_above_the_noise() -> None:
    hum = samples.diagnosis("nothing_missing") | {"error_after": {"force": 0.014}, "noise_floor": {"force": 0.002}}
    assert words.verdict_in_words(hum).endswith(
        "(92 %). But the error of the force is 7 times its noise floor; a comparison shows where."
    )


def test_a_verdict_says_what_is_near_the_truth() -> None:
    bent = samples.diagnosis("nothing_missing") | {"bends_like": "slack"}
    assert words.verdict_in_words(bent).endswith("But a law of the base is bent as slack (1 %) would bend it.")
    probable = samples.diagnosis("unknown")
    probable["probabilities"] |= {"unknown": 0.05, "stress_relaxation": 0.8}
    probable["ranking"][0]["probability"] = 0.8
    assert words.verdict_in_words(probable).startswith(
        "Unknown: stress relaxation (80 %) is probable, but leaves 60 % of the error above the noise."
    )


@pytest.mark.parametrize(
    ("log_odds", "grade", "said"),
    [
        (
            22.0,
            "decisive",
            "tell load cell creep from stress relaxation decisively, with expected odds of more",
        ),
        (3.5, "strong", "with strong evidence, with expected odds of 33 to one"),
        (0.5, "cannot tell", "No motion within these limits tells load cell creep from stress relaxation."),
    ],
)
def test_an_experiment_is_a_sentence(log_odds: float, grade: str, said: str) -> None:
    assert said in words.experiment_in_words(samples.experiment(log_odds, grade))


def test_probabilities_are_shown_and_never_none_nor_all() -> None:
    names = {"stress_relaxation": 0.97, "load_cell_creep": 0.021, "slack": 0.001, "nothing": 0.002, "unknown": 0.006}
    new = samples.diagnosis() | {"probabilities": names}
    assert words.verdict_in_words(new).startswith(
        "Missing: stress relaxation (61 %), hardly told from load cell creep (2 %)."
    )
    assert with_probability(new, "slack") == "slack (< 1 %)"
    assert "(< 1 %)." in words.verdict_in_words(new | {"verdict": "nothing_missing"})
    assert "slack (< 1 %)" in diagnosis_figures.candidates(new)["layout"]["yaxis"]["ticktext"]


def test_all_that_was_found_is_said_with_how_sure_it_is() -> None:
    one = samples.diagnosis()
    second = {"effect": "slack", "law": "slack", "probability": 0.995, "log_evidence": 9.0}
    both = one | {"found": [*one["found"], second], "tied": []}
    said = words.verdict_in_words(both)
    assert said.startswith("Missing: stress relaxation (61 %), then slack (> 99 %). 7 % of the error above the noise")


def test_one_effect_has_one_number_everywhere() -> None:
    found = samples.diagnosis()
    assert words.error_left(found["ranking"][0]) == "38 %"
    assert words.error_left(found["ranking"][2]) == ""
    table = sections.candidates_table(found)
    assert table.rows[0][2:5] == ("61 %", "38 %", "33 to 41 %")
    assert table.rows[2][3] == "not refitted: it would hardly lower the error"
    bars = diagnosis_figures.candidates(found)["data"][0]
    assert bars["x"].round().tolist() == [62.0, 62.0], "what is left and what is gone are a hundred together"


def test_the_interval_of_an_effect_that_adds_to_the_error_is_the_real_one() -> None:
    found = samples.diagnosis()
    found["ranking"][1]["held_out_gain"] = [-0.2, -0.4, 0.1]
    figure = diagnosis_figures.candidates(found)
    bars = figure["data"][0]
    ends = [diagnosis_figures.removed_percent(gain) for gain in (-0.4, 0.1)]
    whiskers = bars["error_x"]
    assert bars["x"][1] - whiskers["arrayminus"][1] == pytest.approx(ends[0])
    assert bars["x"][1] + whiskers["array"][1] == pytest.approx(ends[1])
    assert -104 <= figure["layout"]["xaxis"]["range"][0] < ends[0] < 0
    assert diagnosis_figures.candidates(samples.diagnosis())["layout"]["xaxis"]["range"][0] == 0


def test_two_samples_have_no_distribution_and_the_rest_of_the_report() -> None:
    two = Recording(np.array([0.0, 0.01]), {"displacement_mm": np.array([0.0, 1.0])}, 25.0, "two/recording.csv")
    assert recording_figures.distributions(two) is None
    assert sections.recording_section(two, "Two", "two").items


def test_a_report_says_at_which_rate_the_speed_was_taken_and_nothing_of_a_speed_that_there_is_not() -> None:
    slow = Recording(np.arange(300.0), {"displacement_mm": np.sin(np.arange(300.0)) + 1}, 25.0, "slow.csv")
    still = Recording(np.arange(300.0), {"force_N": np.ones(300), "resistance_ohm": np.ones(300)}, 25.0, "still.csv")
    captions = [sections.recording_section(one, "One", "one").items[-1].caption for one in (slow, still)]
    assert captions == [
        "How often each value occurred; the speed is taken at 1 Hz.",
        "How often each value occurred.",
    ]


def test_clocks_are_told_in_words() -> None:
    assert words.clocks_in_words(0.0004, 0.1, 60.0).endswith("together with the recording; their clocks run alike")
    assert words.clocks_in_words(0.342, 35.0, 1380.0) == (
        "the plan began 0.342 s after the recording; its clock gains 48 ms over the recording (35 ppm)"
    )
    assert "0.100 s before the recording; its clock loses 138 ms" in words.clocks_in_words(-0.1, -100.0, 1380.0)


def test_the_papers_scores_are_those_of_the_compensation_package() -> None:
    for (knit, target), (_, a, b) in COMPENSATED.items():
        name = {"pes": "PES", "lycra": "Lycra"}[knit]
        assert compensator_figures.PAPER[target][name] == pytest.approx((a + b) / 2)


def test_a_base_that_misfits_is_said() -> None:
    assert "the shape of its elasticity is not quite" in words.base_in_words(samples.diagnosis())
    assert words.base_in_words({"base_misfits": []}) == ""
    better = words.base_in_words({"base_misfits": [], "other_laws": ["elasticity_ogden"]})
    assert better == "The law elasticity ogden suits this sensor better."
    two = words.base_in_words({"base_misfits": [], "other_laws": ["elasticity_ogden", "hysteresis_bouc_wen"]})
    assert two == "The laws elasticity ogden and hysteresis bouc wen suit this sensor better."
    both = words.base_in_words({"base_misfits": ["drift_shape"], "other_laws": ["elasticity_ogden"]})
    assert both.startswith("The base law itself misfits: the shape of its drift")
    assert both.endswith(better)


def test_several_shapes_are_one_step_to_a_reader() -> None:
    assert overlays.step_label("+ elasticity_shape, drift_shape") == "+ base shapes"
    assert overlays.step_label("+ stress_relaxation") == "+ stress relaxation"


def ladder_of(count: int) -> list[ladder_figures.Step]:
    """So many steps; the last as bad as the first, so that its bar reaches as high."""
    first, second = samples.steps()
    names = ("+ viscous_rate_stiffening", "+ permanent_set_recovering", "+ load_cell_creep")
    return [first, *(replace(second, label=(names * 4)[number], errors=first.errors) for number in range(count - 1))]


@pytest.mark.parametrize("count", [2, 4, 5, 9])
def test_neither_names_nor_numbers_of_a_ladder_lie_on_anything_else(count: int) -> None:
    drawing = draw(ladder_figures.ladder(ladder_of(count)))
    drawing.canvas.draw()
    for axes in drawing.axes:
        for texts in (axes.get_xticklabels(), axes.texts):
            boxes = [text.get_window_extent() for text in texts]
            assert len(boxes) >= count
            assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))


def test_steps_without_room_for_their_names_are_numbered() -> None:
    layout = ladder_figures.ladder(ladder_of(12))["layout"]
    assert layout["xaxis"]["ticktext"] == [str(number) for number in range(12)]


def test_a_bar_leaves_room_for_the_name_of_the_noise_floor_at_a_glance() -> None:
    drawing = draw(ladder_figures.at_a_glance(samples.overlay(), ladder_of(1), (20.0, 60.0)))
    drawing.canvas.draw()
    for axes in drawing.axes[1::2]:
        number, floor = (text.get_window_extent() for text in axes.texts)
        assert not number.overlaps(floor)


def test_a_tiny_number_stands_whole_at_its_axis() -> None:
    """Its power of ten stood in the corner of the panel, on the title of the one above."""
    small = {"force": 1.5e-5, "conductance": 0.1}
    drawing = draw(ladder_figures.ladder([ladder_figures.Step("baseline", small, small)]))
    drawing.canvas.draw()
    axis = drawing.axes[0].yaxis
    assert any(label.get_text() == "1·10⁻⁵" for label in axis.get_ticklabels())
    assert not axis.get_offset_text().get_text()


@pytest.mark.parametrize(
    ("low", "high", "names"),
    [(0.05, 9, ["0.1", "1"]), (200, 1080, ["200", "500", "1000"]), (2.2, 2.9, ["2.2", "2.9"])],
)
def test_a_logarithmic_axis_has_numbers_however_short_it_is(low: float, high: float, names: list[str]) -> None:
    assert style.log_ticks([low, high])["ticktext"] == names


def test_of_a_slow_recording_the_first_look_is_at_more_than_a_few_samples() -> None:
    both = replace(samples.overlay(), time_s=10.0 * np.arange(len(samples.overlay().time_s)))
    start_s, end_s = comparison_figures.busiest_window(both)
    assert end_s - start_s >= 1990


def test_a_limit_is_drawn_on_both_sides_since_a_recording_stops_beyond_either() -> None:
    limited = replace(FORCE_AND_COMPENSATED, limit=5.0)
    assert {shape["y0"] for shape in live_figures.live([limited])["layout"]["shapes"]} == {5.0, -5.0}


def test_a_result_is_drawn_on_axes_of_its_own_by_the_figure_of_the_report() -> None:
    experiment = experiment_figures.ranking([("fast-triangle", 4e5), ("long-hold", 30.0)])
    (axes,) = draw_on(experiment, None)
    assert axes.get_xscale() == "log"
    assert [name.get_text() for name in axes.get_yticklabels()] == ["fast triangle", "long hold"]


def test_a_motion_that_tells_nothing_has_a_bar_nevertheless_which_tells_that_it_is_nothing() -> None:
    ranking = experiment_figures.ranking([("fast-triangle", 0.03), ("long-hold", 0.0)])
    assert ranking["data"][0]["customdata"].tolist() == [0.03, 0.0]
    assert "customdata" in ranking["data"][0]["hovertemplate"]
    (axes,) = draw_on(ranking, None)
    assert all(bar.get_width() > axes.get_xlim()[0] for bar in axes.patches)


def test_how_far_an_error_has_fallen_is_told_of_its_channel_and_nothing_is_not_less_than_nothing() -> None:
    floor = {"force": 0.1, "conductance": 0.1}
    first = ladder_figures.Step("baseline", {"force": 1.0, "conductance": 1.0}, floor)
    last = ladder_figures.Step("+ slack", {"force": 0.999, "conductance": 0.5}, floor)
    assert sections.fall_in_words(first, last) == "force +0 %, conductance -50 %"
    told = dict(glance_facts([first, last]))
    assert told["the force against the first model"] == "+0 %"
    assert told["the conductance against the first model"] == "-50 %"
    assert dict(glance_facts([first]))["error of the force over its noise floor"] == "10.0 times"
