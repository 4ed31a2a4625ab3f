"""The public functions and the commands give the same on the same files."""

from __future__ import annotations

import json

import numpy as np
import pytest

import gcode
import testbench as tb
from testbench.cli import main
from tests.testbench.api.samples import diagnosed, relaxed
from tests.testbench.builders import write_csv


@pytest.fixture
def file(tmp_path) -> str:
    return write_csv(relaxed(), tmp_path / "a.csv")


def test_diagnose_gives_the_dictionary_that_the_command_writes(file, tmp_path):
    out = tmp_path / "diagnosis.json"
    argv = ["diagnose", file, "--gauge-length-mm", "25", "--repeat", "1", "--quiet", "--json", str(out)]
    assert main(argv) == 0
    assert json.loads(json.dumps(diagnosed().to_dict())) == json.loads(out.read_text())


def test_fit_compare_and_ladder_give_what_the_commands_print(file, tmp_path, capsys):
    model = str(tmp_path / "model.json")
    assert main(["fit", file, "--gauge-length-mm", "25", "-o", model]) == 0
    fit = tb.fit(file, gauge_length_mm=25, progress=False)
    assert capsys.readouterr().out == f"{fit}\nwrote {model}\n"
    fit.save(tmp_path / "mine.json")
    assert (tmp_path / "mine.json").read_text() == (tmp_path / "model.json").read_text()

    assert main(["compare", file, "--model", model, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(tb.compare(file, model).to_dict()))
    assert main(["ladder", model]) == 0
    assert capsys.readouterr().out == f"{fit.ladder}\n"
    assert main(["ladder", model, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == tb.ladder(model).to_dict()


def test_add_gives_the_model_that_the_command_writes(file, tmp_path):
    model, better = str(tmp_path / "model.json"), tmp_path / "better.json"
    fit = tb.fit(file, gauge_length_mm=25, progress=False)
    fit.save(model)
    assert main(["add", "stress_relaxation", "--model", model, "--fit", file, "-o", str(better)]) == 0
    tb.add(model, "stress_relaxation", file, progress=False).save(tmp_path / "mine.json")
    assert (tmp_path / "mine.json").read_text() == better.read_text()


def test_simulate_reads_what_the_command_records(tmp_path):
    made = gcode.generate("paper-1", seed=3, duration_s=60)
    made.write(tmp_path)
    program, folder = str(tmp_path / "program.tap"), tmp_path / "campaign"
    assert main(["run", "--sensor", "pes", "--program", program, "--seed", "7", "-o", str(folder)]) == 0
    recorded, simulated = tb.read(folder), tb.simulate(tb.preset("pes"), made, seed=7)
    assert np.array_equal(recorded.time_s, simulated.time_s)
    assert set(recorded.channels) == set(simulated.channels)
    for name, values in recorded.channels.items():
        assert np.array_equal(values, simulated[name])
    assert np.array_equal(tb.simulate(tb.preset("pes"), program, seed=7)["force_N"], recorded["force_N"])
    (tmp_path / "pes.json").write_text(json.dumps(tb.preset("pes").to_dict()))
    assert np.array_equal(tb.simulate(tmp_path / "pes.json", program, seed=7)["force_N"], recorded["force_N"])


@pytest.mark.slow
def test_propose_gives_what_the_command_writes(file, tmp_path):
    rivals = {}
    for effect in (tb.effects.StressRelaxation(), tb.effects.LoadCellCreep()):
        model = tb.fit(file, gauge_length_mm=25, progress=False).model + effect
        rivals[effect.name] = tb.fit(file, model=model, gauge_length_mm=25, progress=False)
        rivals[effect.name].save(tmp_path / f"{effect.name}.json")
    paths, out = [str(tmp_path / f"{name}.json") for name in rivals], tmp_path / "next.json"
    assert main(["experiment", *paths, "--duration-s", "120", "--json", str(out)]) == 0
    mine = tb.next_experiment(rivals, bounds={"duration_s": 120}, progress=False)
    assert json.loads(json.dumps(mine.to_dict())) == json.loads(out.read_text())
