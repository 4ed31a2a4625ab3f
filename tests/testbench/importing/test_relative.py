"""Resistances told relative to the one at rest: understood where that is given, refused with the remedy where not."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gcode.support.errors import UserError
from testbench.cli import main
from testbench.importing.from_file import look
from testbench.importing.vocabulary.headings import read_heading
from testbench.importing.wish import Wish
from tests.testbench.importing.exports import import_csv

FORMULAS = [
    "dR/R0", "ΔR/R0", "∆R/R0", "ΔR / R₀", "ΔR/R", "delta R/R0", "deltaR/R0", "(R-R0)/R0", "(R − R_0)/R_0",
    "[R-R0]/R0", "(R(t)-R0)/R0", "R/R0-1", "dR_R0", "s1_dR_R0", "Sensor 2 ΔR/R0", "dr/r0", "dR/R_rest",
    "ΔR/Ro", "dR/R0_2",
]  # fmt: skip
WORDS = [
    "Relative resistance change", "relative change in resistance", "Rel. resistance change", "Resistance change",
    "Normalized resistance change", "Fractional change of resistance", "resistance_change", "Resistance Change Rate",
    "Relative Widerstandsänderung", "Widerstandsänderung", "rel. Widerstandsaenderung", "电阻变化率", "相对电阻变化",
    "ΔR", "Delta R",
]  # fmt: skip
RATIOS = [
    "R/R0", "R / R₀", "R/R_0", "s1_R/R0", "R_rel", "relative resistance", "Resistance (relative)", "resistance_rel",
    "Normalised resistance", "relativer Widerstand", "相对电阻",
]  # fmt: skip
UNITS = {"1": 1.0, "-": 1.0, "%": 1e-2, "percent": 1e-2, "‰": 1e-3}
FORMS = ["{name} ({unit})", "{name} [{unit}]", "{name} / {unit}", "{name}, {unit}", "{name} in {unit}"]
OTHERS = [
    "Max resistance change (%)",
    "dR/dt (ohm/s)",
    "Strain change (%)",
]
IN_OHM = [("dR (ohm)", 1.0), ("Resistance change (Ω)", 1.0), ("resistance_change_kohm", 1e3), ("ΔR [kΩ]", 1e3)]
IN_OHM += [("R - R0 (Ohm)", 1.0), ("Sensor 1 Delta R / Ohm", 1.0), ("Widerstandsänderung in kOhm", 1e3)]
REST_OHM, CHANGE = 4700.0, np.linspace(0.01, 0.41, 9)


def written(folder: str, head: str, values: np.ndarray, units_row: str = "") -> Path:
    path = Path(folder) / "lab.csv"
    rows = [f"{i / 10},{i / 5},{value:.12g}" for i, value in enumerate(values)]
    second = [f"s,mm,{units_row}"] if units_row else []
    heads = "Time,Displacement" if units_row else "Time [s],Displacement [mm]"
    path.write_text("\n".join([f'{heads},"{head}"', *second, *rows]) + "\n", encoding="utf-8")
    return path


def the_ratio(name: str) -> np.ndarray:
    return 1 + CHANGE if name in RATIOS else CHANGE


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    name=st.sampled_from([*FORMULAS, *WORDS, *RATIOS]),
    unit=st.sampled_from(list(UNITS)),
    form=st.sampled_from([*FORMS, "row"]),
)
def test_any_name_in_any_unit_is_the_resistance_or_asks_for_the_one_at_rest(name: str, unit: str, form: str) -> None:
    values = the_ratio(name) / UNITS[unit]
    head = name if form == "row" else form.format(name=name, unit=unit)
    with tempfile.TemporaryDirectory() as folder:
        path = written(folder, head, values, unit if form == "row" else "")
        done = import_csv(path, Wish(40.0, r0_ohm=REST_OHM))
        with pytest.raises(UserError, match=r"needs the resistance at rest R0, .* say --rest-ohm R0 in Ω"):
            import_csv(path, Wish(40.0))
    expected = REST_OHM * (1 + CHANGE)
    assert done.recording["resistance_ohm"] == pytest.approx(expected, rel=1e-9), done.taken


@pytest.mark.parametrize("name", [*FORMULAS, *RATIOS])
def test_a_ratio_is_one_where_no_unit_is_said(tmp_path: Path, name: str) -> None:
    done = import_csv(written(str(tmp_path), name, the_ratio(name)), Wish(40.0, r0_ohm=REST_OHM))
    assert done.recording["resistance_ohm"] == pytest.approx(REST_OHM * (1 + CHANGE), rel=1e-9)


@pytest.mark.parametrize("name", WORDS)
def test_a_change_in_words_may_be_in_percent(tmp_path: Path, name: str) -> None:
    path = written(str(tmp_path), name, CHANGE)
    with pytest.raises(UserError, match=r"the file does not say its unit; say --relative-unit \(1, %"):
        import_csv(path, Wish(40.0, r0_ohm=REST_OHM))
    done = import_csv(path, Wish(40.0, r0_ohm=REST_OHM, units={"relative_change": "%"}))
    assert done.recording["resistance_ohm"] == pytest.approx(REST_OHM * (1 + CHANGE / 100), rel=1e-9)


@pytest.mark.parametrize("head", OTHERS)
def test_an_extreme_a_rate_or_another_quantity_is_neither(tmp_path: Path, head: str) -> None:
    _, choice = look(written(str(tmp_path), head, CHANGE), Wish(40.0, r0_ohm=REST_OHM))
    assert set(choice.taken) == {"time", "displacement"}
    assert choice.troubles == []


@pytest.mark.parametrize(("head", "factor"), IN_OHM)
def test_a_change_in_ohm_is_added_to_the_resistance_at_rest(tmp_path: Path, head: str, factor: float) -> None:
    path = written(str(tmp_path), head, CHANGE)
    with pytest.raises(UserError, match=r"needs the resistance at rest R0, .* say --rest-ohm R0 in Ω$"):
        import_csv(path, Wish(40.0))
    found = import_csv(path, Wish(40.0, r0_ohm=REST_OHM)).recording
    assert found["resistance_ohm"] == pytest.approx(REST_OHM + factor * CHANGE, rel=1e-9)


def test_a_ratio_by_its_formula_is_none_in_ohm(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="its unit 'Ohm' cannot be read as one"):
        import_csv(written(str(tmp_path), "dR/R0 [Ohm]", CHANGE), Wish(40.0, r0_ohm=REST_OHM))


def test_a_unit_that_was_said_does_not_make_the_resistance_at_rest_known(tmp_path: Path) -> None:
    """The column was said to be empty."""
    for unit, end in (("%", r"units of R0\)"), ("ohm", "R0 in Ω")):
        with pytest.raises(UserError, match=f"say --rest-ohm .*{end}$"):
            import_csv(written(str(tmp_path), "Resistance change", CHANGE), Wish(units={"relative_change": unit}))


@pytest.mark.parametrize("head", ["Resistance", "R", "Widerstand", "res"])
def test_a_resistance_stays_one(head: str) -> None:
    assert set(read_heading(f"{head} [kΩ]").roles) == {"resistance"}


def test_what_falls_by_more_than_itself_is_in_percent(tmp_path: Path) -> None:
    path = written(str(tmp_path), "dR/R0", np.array([0.0, -5.2, 3.0]))
    with pytest.raises(UserError, match=r"row 3: column 3 'dR/R0' is -5.2, .* say --relative-unit %"):
        import_csv(path, Wish(40.0, r0_ohm=REST_OHM))
    percent = import_csv(path, Wish(40.0, r0_ohm=REST_OHM, units={"relative_change": "%"}))
    assert percent.recording["resistance_ohm"] == pytest.approx(REST_OHM * np.array([1, 0.948, 1.03]))


def test_what_grows_too_much_to_be_true_is_said(tmp_path: Path) -> None:
    big = import_csv(written(str(tmp_path), "dR/R0", np.array([0.0, 41.0, 3.0])), Wish(40.0, r0_ohm=REST_OHM))
    assert big.doubts == ["column 3 'dR/R0' reaches 42 times R0; if it is in %, say --relative-unit %"]
    said = import_csv(written(str(tmp_path), "dR/R0 [1]", np.array([0.0, 41.0, 3.0])), Wish(40.0, r0_ohm=REST_OHM))
    assert said.doubts == []


def test_the_command_takes_it(tmp_path: Path, capsys) -> None:
    path, out = written(str(tmp_path), "ΔR/R0 (%)", 100 * CHANGE), tmp_path / "knit"
    words = ["import", str(path), "--gauge-length-mm", "40", "-o", str(out)]
    assert main(words) == 2
    assert "say --rest-ohm R0 in Ω" in capsys.readouterr().err
    assert main([*words, "--rest-ohm", "4700"]) == 0
    assert "resistance_ohm 4747 to 6627" in capsys.readouterr().out


def test_of_several_sensors_one_is_asked_for(tmp_path: Path, capsys) -> None:
    path = tmp_path / "sleeve.csv"
    rows = "".join(f"{i / 10},{i / 5},{i / 50},{i / 40},{i / 30}\n" for i in range(9))
    path.write_text(f"time_s,displacement_mm,s1_dR_R0,s2_dR_R0,s3_dR_R0\n{rows}")
    words = ["import", str(path), "--gauge-length-mm", "40", "--rest-ohm", "100", "-o", str(tmp_path / "knit.csv")]
    assert main(words) == 2
    told = capsys.readouterr().err
    assert "column 3 's1_dR_R0', column 4 's2_dR_R0' and column 5 's3_dR_R0' all fit relative change" in told
    assert "--relative-change 5" in told
    assert main([*words, "--relative-change", "s2_dR_R0"]) == 0
    assert "resistance_ohm 100 to 120" in capsys.readouterr().out
