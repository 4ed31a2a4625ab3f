"""What a column is taken for where its name speaks of something near: another resistance, another strain."""

from __future__ import annotations

import pytest

from gcode.support.errors import UserError
from testbench.importing.from_file import import_csv
from testbench.importing.wish import Wish


def table(folder, *names):
    """A file of a time, a displacement and these columns, each of which rises by 1 from its number times 100."""
    rows = [",".join(["Time (s)", "Displacement (mm)", *names])]
    cells = [[0.1 * n, 0.5 * n, *(100 * at + n for at, _ in enumerate(names, 1))] for n in range(4)]
    rows += [",".join(map(str, row)) for row in cells]
    # * n, *(100 * at + n for at, _ in enumerate(names, 1))])) for n in range(4)]
    path = folder / "lab.csv"
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize("rest", ["R0", "R_0", "R_o", "R_ref", "R ref", "R_init", "R_rest", "R_series"])
def test_the_resistance_at_rest_is_not_the_one_that_is_measured(tmp_path, rest):
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
