"""What the pictures of the results show: names, units, and labels that do not lie on each other."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.collections import PathCollection

import testbench as tb
from gcode.support.figures import PANEL_IN, WIDTH_IN
from testbench.api.models.ladder import Ladder
from testbench.comparing.residual_coordinates import COORDINATES
from testbench.report.figures.residual_figures import COORDINATE_TITLES
from tests.testbench.api.samples import diagnosed, fitted, relaxed

mpl.use("Agg")
WORDS = ("+ shape freedom", "+ stress_relaxation", "+ viscous_rate_stiffening", "+ permanent_set_recovering")


def drawn(plot, count: int):
    """The axes of a picture as a notebook shows it, laid out."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH_IN, PANEL_IN * count), layout="constrained")
    on = plot(list(figure.subplots(count, 1, squeeze=False)[:, 0]))
    figure.canvas.draw()
    return on


def ladder_of(count: int) -> Ladder:
    """The fitted model's ladder with more steps behind its first."""
    file = fitted().file
    (first,) = file.history
    names = ["baseline", *(WORDS * 3)[: count - 1]]
    return Ladder(replace(file, history=tuple({**first, "step": name} for name in names)))


@pytest.mark.parametrize("count", [2, 5, 7, 9])
def test_the_names_of_steps_do_not_lie_on_each_other(count):
    for axis in drawn(ladder_of(count).plot, 2):
        names = axis.get_xticklabels()
        assert [name.get_text().replace("\n", " ")[:6] for name in names[:2]] == ["baseli", "+\N{NO-BREAK SPACE}shap"]
        boxes = [name.get_window_extent() for name in names]
        assert all(left.x1 < right.x0 for left, right in pairwise(boxes))


def test_no_label_is_longer_than_its_panel_is_high():
    where = tb.compare(relaxed(), fitted())
    for plot in (ladder_of(3).plot, fitted().plot, where.plot):
        for axis in drawn(plot, 2):
            assert axis.yaxis.label.get_window_extent().height <= axis.get_window_extent().height


def test_every_coordinate_of_a_comparison_has_its_unit_as_in_a_report():
    where = tb.compare(relaxed(), fitted())
    assert set(COORDINATES) == set(COORDINATE_TITLES)
    for name in ("strain", "strain_rate", "elapsed_s", "since_reversal_s"):
        (axis, _) = drawn(lambda on, name=name: where.plot(on, coordinate=name), 2)
        assert axis.get_xlabel() == COORDINATE_TITLES[name]
        assert axis.get_xlabel().endswith(("(%)", "(%/s)", "(s)"))


def test_strain_is_drawn_in_percent_and_the_ways_differ_by_more_than_colour():
    (axis, _) = drawn(lambda on: tb.compare(relaxed(), fitted()).plot(on, coordinate="strain"), 2)
    stretching, releasing = (dots for dots in axis.collections if isinstance(dots, PathCollection))
    assert max(stretching.get_offsets()[:, 0]) > 5
    assert len(stretching.get_paths()[0].vertices) != len(releasing.get_paths()[0].vertices)


def test_a_diagnosis_names_every_bar_in_words_with_its_probability():
    names = [label.get_text() for label in drawn(diagnosed().plot, 1).get_yticklabels()]
    assert any(name.startswith("nothing is missing (") for name in names)
    assert any(name.startswith("something that no effect explains (") for name in names)
    assert all(name.endswith(" %)") for name in names)


def test_what_a_candidate_would_add_is_named_as_the_residual_that_it_is():
    first, second = drawn(tb.contribution(diagnosed(), "stress_relaxation", relaxed()).plot, 2)
    assert [axis.get_ylabel() for axis in (first, second)] == ["Force\nresidual (N)", "Conductance\nresidual (ln S)"]
    said = [text.get_text() for text in first.get_legend().get_texts()]
    assert said[0] == "what the model leaves"
    assert re.fullmatch(r"what stress relaxation[a-z ]* would add", said[1])


def test_no_line_is_drawn_over_a_gap():
    whole = relaxed().to_frame()
    gappy = tb.read(whole[(whole["time_s"] < 40) | (whole["time_s"] > 60)], 25)
    ((start_s, end_s),) = gappy.gaps
    for plot, count in ((gappy.plot, 3), (tb.fit(gappy, progress=False).plot, 2)):
        for axis in drawn(plot, count):
            for line in axis.get_lines():
                x, y = line.get_xdata(), line.get_ydata()
                inside = (x[1:] > start_s + 0.5) & (x[:-1] < end_s - 0.5)
                assert inside.any()
                assert np.isnan(y[1:] + y[:-1])[inside].all()
    assert gappy._repr_html_().count("<polyline") == 2 * relaxed()._repr_html_().count("<polyline")
