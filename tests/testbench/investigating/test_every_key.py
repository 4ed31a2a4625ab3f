"""Every key of ``investigation.json`` changed in every way, and the investigation resumed: a sentence or a run."""

from __future__ import annotations

import json
import shutil

import pytest

from testbench.cli import main
from testbench.investigating import loop
from testbench.investigating.state import NAME
from tests.fuzz.every_key import fault_of, mutants
from tests.testbench.investigating.samples import hidden, scripted_belief

QUICK = 150  # mutants in the quick suite


@pytest.fixture(scope="module")
def unfinished(tmp_path_factory):
    """The folder of an investigation that was stopped after its first run of two, and its state."""
    folder = tmp_path_factory.mktemp("every-key") / "i"
    sensor = folder.parent / "hidden.json"
    sensor.write_text(json.dumps(hidden().to_dict()))
    brief = ["--run-minutes", "2", "--budget-minutes", "4", "--trials", "1", "--rest-s", "5", "--quiet"]
    with pytest.MonkeyPatch.context() as patch:
        scripted_belief(patch, 0.6, 0.99)
        assert main(["investigate", str(sensor), "-o", str(folder), *brief]) == 0
    state = json.loads((folder / NAME).read_text())
    shutil.rmtree(folder / "plan-2")
    shutil.rmtree(folder / "run-2")
    return folder, state | {"runs": state["runs"][:1], "ended": ""}


def faults(unfinished, place, monkeypatch, most: int = 1_000_000) -> list[str]:
    """What `most` mutants do wrong, evenly spread over the keys."""
    folder, state = unfinished
    found = []
    for mutant in mutants(state, most=most):
        scripted_belief(monkeypatch, 0.99, 0.99)
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(folder, place)
        (place / NAME).write_text(mutant.text)
        if fault := fault_of(f"testbench investigate --resume --quiet -o {place} --json {place}.json"):
            found.append(f"{mutant.change}: {fault}")
    return found


def test_a_changed_key_gets_a_sentence(unfinished, tmp_path, monkeypatch):
    # The design of the next motion is slow and has a turn of its own, in the slow suite.
    monkeypatch.setattr(loop._Loop, "_plan", lambda self: setattr(self, "state", _spent(self.state)))
    assert faults(unfinished, tmp_path / "i", monkeypatch, QUICK) == []


def _spent(state):
    return state.model_copy(update={"ended": "the time is spent"})


@pytest.mark.slow
def test_a_changed_key_gets_a_sentence_or_the_next_run(unfinished, tmp_path, monkeypatch):
    assert faults(unfinished, tmp_path / "i", monkeypatch) == []
