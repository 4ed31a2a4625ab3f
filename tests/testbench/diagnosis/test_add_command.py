"""`testbench add` on a sensor whose conductance falls with stretch."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np

from testbench.api.models import adding
from testbench.api.models.fitting import FitResult
from testbench.cli import main
from testbench.knit.catalogue import baseline
from testbench.knit.mechanics.damage import MullinsSoftening
from testbench.knit.mechanics.relaxation import StressRelaxation
from testbench.knit.model import KnitModel
from testbench.recordings.files import write_recording_csv
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile


def test_adding_never_tries_to_leave_out_the_law_that_makes_the_conductance(tmp_path: Path, capsys) -> None:
    time_s = np.arange(1600) * 0.1
    strain = 0.12 + 0.06 * np.sin(0.9 * time_s) + 0.05 * np.sin(0.37 * time_s + 1.0)
    noise = np.random.default_rng(5).normal(size=(2, len(time_s)))
    channels = {
        "displacement_mm": 25 * strain,
        "force_N": 5 * strain + 0.01 * noise[0],
        "resistance_ohm": 1000 * np.exp(3 * strain + 0.002 * noise[1]),
    }
    write_recording_csv(tmp_path / "strip.csv", Recording(time_s, channels, 25.0))
    model, recording = str(tmp_path / "model.json"), str(tmp_path / "strip.csv")
    assert main(["fit", recording, "--gauge-length-mm", "25", "-o", model]) == 0
    assert "piezoresistance" in Path(model).read_text()
    assert main(["add", "piezoresistance", "--model", model, "--fit", recording, "-o", model]) == 2
    assert "add piezoresistance: the model has this law already" in capsys.readouterr().err
    assert main(["add", "piezoresistance_tunnelling", "--model", model, "--fit", recording, "-o", f"{model}2"]) == 0
    assert "piezoresistance_tunnelling takes the place of piezoresistance: a model has" in capsys.readouterr().err
    assert main(["add", "channel_lag", "--model", model, "--fit", recording, "-o", model]) == 0
    assert "takes the place" not in capsys.readouterr().err
    assert [step["step"] for step in json.loads(Path(model).read_text())["history"]] == ["baseline", "+ channel_lag"]


def test_undo_takes_no_effect(tmp_path: Path, capsys) -> None:
    assert main(["add", "--undo", "drift", "--model", "absent.json", "-o", str(tmp_path / "m.json")]) == 2
    assert "takes the last step back, whatever it was" in capsys.readouterr().err


def test_an_effect_that_was_just_added_is_not_asked_whether_it_still_pays(monkeypatch) -> None:
    """A second one of a law has a number behind its name."""
    monkeypatch.setattr(adding, "idle_effects", lambda *given: sorted(given[-1]))
    model = KnitModel.of(*baseline().effects.values(), StressRelaxation(), StressRelaxation(), MullinsSoftening())
    found = cast(FitResult, SimpleNamespace(model=model, file=None, calibration=None, held_out=None))
    assert adding.no_longer_pays(found, "stress_relaxation") == ["mullins_softening"]


def test_a_step_that_fits_worse_says_so() -> None:
    """A law in place of another one may: piezoresistance in place of contact went from 0.7 noise floors to 40."""
    floor = {"force": 0.01}
    before, better, worse = (
        {"fitted_on": "a.csv", "noise_floor": floor, "errors": {"calibration": {"force": error}}}
        for error in (0.02, 0.01, 0.05)
    )
    said = "the model fits worse than before: its error was 2 noise floors, and is 5; undo takes the step back"
    assert adding._worse_fitted(ModelFile(baseline(), 25.0, history=(before, worse))) == [said]
    others = [(before, better), (before, before), (worse,), ({**before, "fitted_on": "b.csv"}, worse)]
    assert not any(adding._worse_fitted(ModelFile(baseline(), 25.0, history=steps)) for steps in others)
