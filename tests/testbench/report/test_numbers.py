"""Numbers as people read them, and where a model fails."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tests.testbench.report.samples as samples
from testbench import effects
from testbench.comparing.cell import Cell
from testbench.comparing.compare import Place
from testbench.comparing.numbers import allowed, plain, span, with_error
from testbench.comparing.tables import fit_table
from testbench.knit.catalogue import baseline
from testbench.report import overlays
from testbench.report.downsample import liveliest
from testbench.report.figures.comparison_figures import Overlay
from testbench.report.overlays import LOOK_S
from testbench.report.parameter_table import name_without_unit, parameter_table
from testbench.report.words import odds_in_words, verdict_in_words
from testbench.results.model_file import ModelFile


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (966, "966"),
        (1100, "1100"),
        (0.0364, "0.0364"),
        (0, "0"),
        (2.14e-7, "2.14·10⁻⁷"),
        (-5.796, "-5.80"),
        (5e-324, "4.94·10⁻³²⁴"),
        (9.999e-5, "1.00·10⁻⁴"),
        (9.9996, "10.0"),
        (99.96, "100"),
    ],
)
def test_numbers_have_three_digits_and_no_exponent(value: float, text: str) -> None:
    assert plain(value) == text


@given(st.floats(1e-4, 9e6))
def test_a_number_that_is_written_is_the_number_to_half_a_percent(value: float) -> None:
    text = plain(value)
    assert float(text) == pytest.approx(value, rel=5.1e-3)
    assert not re.search("[eE]", text)


def test_both_ends_of_a_span_have_the_same_decimals() -> None:
    assert span(966, 1103, "s") == "970 to 1100 s"
    assert span(0.31, 9.1, "%") == "0.31 to 9.10 %"
    assert span(0, 0, "s") == "0 to 0 s"


def test_a_value_stops_where_its_error_begins() -> None:
    assert with_error(5.7955, 0.19979, "N") == "5.80 ± 0.20 N"
    assert with_error(369172.0, 16034.0, "ohm") == "369 ± 16 kΩ"
    assert with_error(1554.5, 4183.0, "s") == "1600 ± 4200 s"
    assert with_error(1.07e-7, 1.5e-8, "S") == "107 ± 15 nS"
    assert with_error(0.4, float("inf"), "1") == "0.400 ± inf"


def test_a_range_is_written_as_it_was_declared() -> None:
    assert allowed(0.1, 3000, "s") == "0.1 to 3000 s"
    assert allowed(1e-12, 100, "S") == "0.001 nS to 100 S"
    assert allowed(0, 1, "1") == "0 to 1"


def test_parameters_say_what_they_are_and_what_to_doubt() -> None:
    fit = {
        "parameters": {
            "elasticity.stiffness_N": {"value": 5.8, "unit": "N", "standard_error": 0.2},
            "drift.tau_s": {"value": 1554.0, "unit": "s", "standard_error": 4200.0},
            "elasticity_shape.weights_N[0]": {"value": 0.1, "unit": "N", "standard_error": 0.1},
        },
        "at_bound": ["elasticity.stiffness_N"],
        "unidentified": ["drift.tau_s", "elasticity.stiffness_N"],
        "correlated": [["drift.tau_s", "elasticity.stiffness_N", 0.99]],
    }
    table = parameter_table(fit, baseline())
    assert table is not None
    stiff, tau = table.rows
    assert stiff[:2] == ("elasticity: stiffness", "5.80 N"), "at a bound nothing is known of its error"
    assert stiff[3] == "at a bound; hardly told from drift: tau"
    assert tau[3].startswith("this recording cannot tell")
    assert "N" in stiff[2]
    assert stiff[4]
    assert "Another 1 numbers" in table.caption


def test_slips_are_told_with_their_moments() -> None:
    """They were counted among the numbers that give shapes their form, and called so by the terminal."""
    law = effects.ClampSlipEvents
    model = baseline() + law(amounts=(0.02, 0.03, *(0.0,) * 10), slip_times_s=(90.0, 40.0, *(1e5,) * 10))
    sizes = [(0.02, 1e-3), (0.03, 1e-3), (0.001, 1e-3), *[(0.0, 0.1)] * 9]
    parameters = {
        f"clamp_slip_events.amounts[{n}]": {"value": value, "unit": "1", "standard_error": error}
        for n, (value, error) in enumerate(sizes)
    }
    fit = {
        "parameters": parameters,
        "at_bound": ["clamp_slip_events.amounts[3]"],
        "unidentified": [],
        "correlated": [],
    }
    table = parameter_table(fit, model)
    assert table is not None
    told = "0.0300 ± 0.0010 at 40.00 s; 0.0200 ± 0.0010 at 90.00 s"
    assert table.rows == [
        ("clamp slip events: amounts", told, "0 to 0.5", "those of this recording alone", "slips, as strain")
    ]
    assert "give shapes" not in table.caption
    assert fit_table(ModelFile(model, 25.0, fit=fit)).split() == ["clamp_slip_events.amounts", *told.split()]


@pytest.mark.parametrize(("value", "error"), [(5.699724, 5.7e-6), (-0.175, 1e-6), (0.0, 1e-6)])
def test_the_error_of_what_was_held_is_not_shown_as_knowledge(value: float, error: float) -> None:
    entry = {"value": value, "unit": "N", "standard_error": error}
    table = parameter_table({"parameters": {"elasticity.offset_N": entry}}, baseline())
    assert table is not None
    assert "±" not in table.rows[0][1]
    assert table.rows[0][3] == "held while the rest was fitted"
    fitted = parameter_table({"parameters": {"elasticity.offset_N": entry | {"standard_error": 1e-3}}}, baseline())
    assert fitted is not None
    assert "±" in fitted.rows[0][1]


def test_the_channels_that_have_reached_their_noise_are_told() -> None:
    compared = samples.comparison()
    assert compared.noise_reached == []
    assert replace(compared, rms={"force": 0.0102, "conductance": 0.12}).noise_reached == ["force"]


@given(st.integers(0, 3500))
def test_the_stretch_holds_the_burst(start: int) -> None:
    time_s = np.arange(4000) * 0.05
    energy = np.zeros(4000)
    energy[start : start + 100] = 1.0
    low, high = liveliest(time_s, energy, LOOK_S)
    assert low <= time_s[start]
    assert high >= time_s[start + 99]
    assert high - low == pytest.approx(29.95)


def test_a_spot_is_looked_for_inside_its_cell_only(monkeypatch: pytest.MonkeyPatch) -> None:
    time_s = np.arange(4000) * 0.05
    where = {"strain": np.full(4000, 0.2), "direction": np.ones(4000)}
    where["strain"][3000:3100] = 0.045
    where["direction"][3050:] = -1
    monkeypatch.setattr(overlays, "coordinates", lambda _measurement: where)
    worst = Place("force", "strain", Cell(0.04, 0.05, 1, -0.1, 0.01, 0.1), 0.4, "too high")
    flat = {"force": np.full(4000, 5.0)}
    both = Overlay(time_s, where["strain"], flat, {"model": {"force": np.zeros(4000)}}, {})
    counts = SimpleNamespace(counts=np.ones(4000, bool))
    ((start_s, end_s),) = overlays.spans_of(samples.comparison(worst=(worst,)), counts, both)  # type: ignore[arg-type]
    assert start_s <= time_s[3000]
    assert end_s >= time_s[3049]


def test_what_is_rounded_up_has_no_digit_more() -> None:
    assert with_error(9.996, 0.0996, "N") == "10.00 ± 0.10 N"
    assert span(0.1, 9.996, "s") == "0.1 to 10.0 s"


def test_evidence_is_said_as_odds_and_a_parameter_without_its_unit() -> None:
    assert [odds_in_words(nats) for nats in (0.0, 2.5, 88.0)] == [
        "1.0 to one",
        "12 to one",
        "more than a million to one",
    ]
    assert [name_without_unit(key) for key in ("tau_s", "fraction", "gain_N")] == ["tau", "fraction", "gain"]


@pytest.mark.parametrize(("held_N", "says"), [(0.012, ""), (0.05, "what was found does not carry over")])
def test_a_verdict_says_as_the_terminal_does_where_what_was_found_does_not_carry_over(
    held_N: float, says: str
) -> None:
    before, after = (
        {"errors": {"calibration": {"force": one}, "held_out": {"force": held_N}}} for one in (0.1, 0.01)
    )
    diagnosis = samples.diagnosis() | {"history": [before, after], "noise_floor": {"force": held_N}}
    diagnosis |= {"error_before": {"force": 0.1}, "error_after": {"force": held_N}}
    assert len(diagnosis["found"]) == 1
    told = verdict_in_words(diagnosis)
    assert ("But held out the error of the force is 5 times as large: " in told) == bool(says)
    assert says in told


def test_what_a_parameter_is_says_the_names_of_others_in_words() -> None:
    entries = {"hysteresis.friction_N": {"value": 1.0, "unit": "N", "standard_error": 0.1}}
    table = parameter_table({"parameters": entries}, baseline() + effects.HysteresisOnTension())
    assert table is not None
    assert table.rows[0][4] == "force at tension, slipping"
