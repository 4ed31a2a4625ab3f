"""What a column is taken for where its name speaks of something near: another resistance, another strain."""

from __future__ import annotations

import pytest

from gcode.support.errors import UserError
from testbench.importing.sheet import Hints
from testbench.importing.wish import Wish
from tests.testbench.importing.exports import import_csv


def table(folder, *names):
    """A file of a time, a displacement and these columns, each of which rises by 1 from its number times 100."""
    rows = [",".join(["Time (s)", "Displacement (mm)", *names])]
    cells = [[0.1 * n, 0.5 * n, *(100 * at + n for at, _ in enumerate(names, 1))] for n in range(4)]
    rows += [",".join(map(str, row)) for row in cells]
    path = folder / "lab.csv"
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize("rest", ["R0", "R_0", "R_o", "R_ref", "R ref", "R_init", "R_rest", "R_series"])
def test_the_resistance_at_rest_is_not_the_one_that_is_measured(tmp_path, rest):
    assert not import_csv(table(tmp_path, f"{rest.replace(' ', '_')}_ohm"), Wish(40.0)).recording.has(
        "resistance_ohm"
    )
    path = table(tmp_path, f"{rest} (Ohm)", "dR/R0 (%)")
    with pytest.raises(UserError, match=r"relative change .*needs the resistance at rest R0"):
        import_csv(path, Wish(40.0))
    recording = import_csv(path, Wish(40.0, r0_ohm=1000.0)).recording
    assert recording["resistance_ohm"].tolist() == pytest.approx([3000, 3010, 3020, 3030])


@pytest.mark.parametrize("other", ["R_shunt", "Shunt resistance", "Series resistor", "R_x"])
def test_the_conductance_is_not_left_for_another_resistance(tmp_path, other):
    recording = import_csv(table(tmp_path, f"{other} (Ohm)", "Conductance (S)"), Wish(40.0)).recording
    assert recording.conductance_S.tolist() == pytest.approx([200, 201, 202, 203])


@pytest.mark.parametrize("name", ["R", "R2", "Sensor resistance", "R_x"])
def test_the_measured_resistance_is_taken_before_what_is_made_of_it(tmp_path, name):
    """A letter with a word behind it is taken, too, where nothing else is there."""
    more = [] if name == "R_x" else ["dR/R0 (%)"]
    recording = import_csv(table(tmp_path, f"{name} (Ohm)", *more), Wish(40.0)).recording
    assert recording["resistance_ohm"].tolist() == [100, 101, 102, 103]


DERIVED = ["Log resistance (Ohm)", "Log10 R [Ohm]", "ln(R) [Ohm]", "1/Resistance (1/Ohm)", "NTC resistance (Ohm)"]
DERIVED += ["Force per wale [N]", "Force offset [N]", "Inverse resistance [Ohm]"]
DERIVED += ["Force^2 [N]", "Force² [N]", "Delta force (N)", "Kraftänderung [N]", "F_err (N)"]
DERIVED += ["Resistance tolerance (Ohm)", "RMS force (N)"]


def test_a_column_of_g_may_be_of_an_acceleration(tmp_path):
    """A name that says nothing does not make a force of it; a person may."""
    path = table(tmp_path, "AI0 [g]", "R (Ohm)")
    found = import_csv(path, Wish(40.0))
    assert not found.recording.has("force_N")
    assert "not used: column 3 'AI0 [g]'" in "\n".join(found.notes)
    said = import_csv(path, Wish(40.0, columns={"force": "3"})).recording
    assert said["force_N"][0] == pytest.approx(0.980665)
    assert import_csv(table(tmp_path, "AI0 [kg]"), Wish(40.0)).recording.has("force_N")


@pytest.mark.parametrize("name", DERIVED)
def test_what_was_made_of_a_quantity_is_not_the_quantity(tmp_path, name):
    """A logarithm below Ω was read as ohms."""
    path = table(tmp_path, name)
    if name.startswith("1/"):
        with pytest.raises(UserError, match=r"resistance .* does not say its unit"):
            import_csv(path, Wish(40.0))
        return
    assert set(import_csv(path, Wish(40.0)).recording.channels) == {"displacement_mm"}


def test_the_unit_tells_of_what_a_name_may_be_what_it_is(tmp_path):
    """It was asked for a temperature in Ω; a second resistance was not seen beside it."""
    recording = import_csv(table(tmp_path, "R_temp_comp [Ohm]", "t_force [N]"), Wish(40.0)).recording
    assert recording["resistance_ohm"].tolist() == [100, 101, 102, 103]
    assert recording["force_N"].tolist() == [200, 201, 202, 203]
    with pytest.raises(UserError, match=r"column 3 'R_raw .* and column 4 'R_temp_comp .* both fit resistance"):
        import_csv(table(tmp_path, "R_raw [Ohm]", "R_temp_comp [Ohm]"), Wish(40.0))


@pytest.mark.parametrize(
    "names", ["T_S,X_MM,F_N", "timeS,posMm,forceN", "Time (s) Run #1,Position (mm) Run #1,F (N) 1"]
)
def test_units_behind_names_of_programs(tmp_path, names):
    (tmp_path / "lab.csv").write_text("\n".join([names, *(f"0.{n},{2 * n},{3 * n}" for n in range(9))]))
    recording = import_csv(tmp_path / "lab.csv", Wish(40.0)).recording
    assert recording["displacement_mm"].tolist() == [2 * n for n in range(9)]
    assert recording["force_N"].tolist() == [3 * n for n in range(9)]


@pytest.mark.parametrize(
    "name", ["Load (0.1 N)", "Load (0,01 N)", "Load (tens of N)", "Load (milli N)", "Load (5 N)", "Load cell (50 N)"]
)
def test_a_unit_behind_a_number_in_brackets_is_none(tmp_path, name):
    """Tenths of a newton were read as newtons."""
    with pytest.raises(UserError, match=r"force .*does not say its unit|its unit"):
        import_csv(table(tmp_path, f'"{name}"'), Wish(40.0))
    recording = import_csv(table(tmp_path, f'"{name} [N]"'), Wish(40.0)).recording
    assert recording["force_N"].tolist() == [100, 101, 102, 103]


@pytest.mark.parametrize("units", ["", "s,mm,mm,N\n"])
def test_names_of_several_columns_have_parts_below_them(tmp_path, units):
    """Where cells are merged, the first of the columns was taken: the displacement that was set."""
    names = "Time,Displacement,,Force" if units else "Time (s),Displacement (mm),,Force (N)"
    path, rows = tmp_path / "lab.csv", "".join(f"{n},{n + 5},{n},{2 * n}\n" for n in range(9))
    path.write_text(f"{names}\n,set,actual,\n{units}{rows}")
    assert import_csv(path, Wish(40.0)).recording["displacement_mm"].tolist() == list(range(9))
    path.write_text(f"{names}\n,left,right,\n{units}{rows}")
    with pytest.raises(UserError, match=r"left Displacement.* and column 3 'right Displacement.* both fit"):
        import_csv(path, Wish(40.0))


def test_words_that_speak_about_most_roles_are_plain_for_some(tmp_path):
    path = tmp_path / "lab.csv"
    path.write_text("Cumulative time (s),Position (mm),NTC temperature (C)\n0,1,20\n0.1,2,21\n0.2,3,22\n")
    assert import_csv(path, Wish(40.0)).recording["temperature_C"].tolist() == [20, 21, 22]


STRAINS = ["True strain", "Log. strain", "Logarithmic strain", "Hencky strain", "Transverse strain", "strain_lateral"]
STRAINS += ["Querdehnung", "wahre Dehnung", "真应变", "ε_true"]


@pytest.mark.parametrize("name", STRAINS)
def test_another_strain_than_the_nominal_one_is_not_taken_for_it(tmp_path, name):
    path = tmp_path / "lab.csv"
    path.write_text(f"Time (s),{name} (%),Force (N)\n0,0,0\n0.1,1,0.1\n0.2,2,0.2\n")
    with pytest.raises(UserError, match="no displacement found"):
        import_csv(path, Wish(40.0))
    recording = import_csv(path, Wish(40.0, {"strain": "2"})).recording
    assert recording["displacement_mm"].tolist() == pytest.approx([0, 0.4, 0.8])


STRETCHED = "Time (s),Extension (%),Force (N)\n0,0,0\n0.1,1,0.1\n0.2,2,0.2\n"
IDLE = [
    ({"units": {"displacement": "mm"}}, "--displacement-unit is of what no column .*strain: column 2.*leave it out"),
    (
        {"units": {"relative": "furlong", "relative_change": "furlong"}},
        "--relative-unit is of what no column is taken",
    ),
    ({"units": {"resistance_ohm": "kOhm"}}, "units: can be said of time, .*resistance.* got 'resistance_ohm'"),
    ({"columns": {"forces": "3"}}, "columns: can be said of .*force.* got 'forces'"),
    ({"time_of": {"resistance": "3"}}, "--time-of resistance= is of what no column is taken for"),
    ({"time_of": {"time": "1"}}, "time_of: can be said of displacement, .* got 'time'"),
    (
        {"columns": {"time": "1"}, "rate_hz": 10.0},
        "column 1 'Time .s.' is taken for them; leave --rate-hz or --time out",
    ),
]


@pytest.mark.parametrize(("said", "message"), IDLE)
def test_what_is_said_of_nothing_is_not_left_out_in_silence(tmp_path, said, message):
    path = tmp_path / "lab.csv"
    path.write_text(STRETCHED)
    with pytest.raises(UserError, match=message):
        import_csv(path, Wish(40.0, **said))


NO_WISH = [
    ({"columns": {"force": 3}}, "columns: force must be a text such as '3', got 3"),
    ({"columns": "force"}, "columns: must be a mapping of roles to texts"),
    ({"negate": "force"}, "negate: must be a set of roles"),
    ({"zero": {"force": 0.5}}, "zero: force must be a text such as '0.5', got 0.5"),
    ({"rate_hz": 0}, "rate_hz: must be a positive number, got 0"),
    ({"rate_hz": -10.0}, "rate_hz: must be a positive number, got -10.0"),
    ({"r0_ohm": float("nan")}, "r0_ohm: must be a positive number, got nan"),
    ({"hints": {"decimal": ","}}, "hints: must be a testbench.Hints"),
]


@pytest.mark.parametrize(("said", "message"), NO_WISH)
def test_a_wish_that_cannot_be_is_refused_where_it_is_made(said, message):
    with pytest.raises(UserError, match=message):
        Wish(40.0, **said)


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ({"decimal": ";"}, "`decimal` must be ',' or '.', got ';'"),
        ({"separator": 3}, "`separator` must be a text, got 3"),
        ({"units_row": "2"}, "`units_row` .* must be a whole number, 0 or more, got '2'"),
    ],
)
def test_hints_that_cannot_be_are_refused(said, message):
    with pytest.raises(UserError, match=message):
        Hints(**said)
