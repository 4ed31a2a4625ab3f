"""The catalogue, cards, template and presets, and the command that shows them."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gcode.support.errors import UserError
from testbench.cli import main
from testbench.knit import rules
from testbench.knit.card import card_text, catalogue_markdown, catalogue_text, doc_sections
from testbench.knit.catalogue import load_catalogue, model_from_dict
from testbench.knit.effect import bounds_of
from testbench.knit.model import KnitModel, inputs
from testbench.knit.presets import names, preset
from testbench.knit.rules import check
from testbench.knit.showcase import VISIBLE, showcase
from testbench.knit.template import write_template

CATALOGUE = load_catalogue()


def test_a_mechanism_is_spoken_for_by_the_law_that_is_called_like_it() -> None:
    assert all(effect.name == name for name, effect in CATALOGUE.effects.items())
    assert all(laws[0].name == mechanism for mechanism, laws in CATALOGUE.mechanisms().items())


@pytest.mark.parametrize("name", CATALOGUE.effects)
def test_card_shows_formula_parameters_and_source(name: str) -> None:
    effect = CATALOGUE[name]
    text = card_text(effect, CATALOGUE)
    doc = doc_sections(effect)
    assert doc.formula
    assert all(re.search("[=(]", line) for line in doc.formula.splitlines()), "what explains it stands below"
    assert doc.source
    assert doc.valid
    assert all(line in text for line in doc.formula.splitlines())
    for key, field in effect.model_fields.items():
        assert key in text
        assert f"{bounds_of(field)['high']:g}" in text


def test_list_names_every_effect() -> None:
    text = catalogue_text(CATALOGUE)
    assert all(name in text for name in CATALOGUE.effects)
    assert catalogue_markdown(CATALOGUE).count("\n") == len(CATALOGUE.effects) + 1


def test_the_list_puts_no_law_below_one_of_another_mechanism() -> None:
    above = None
    for name in re.findall(r"^ +\w+", catalogue_text(CATALOGUE), re.MULTILINE):
        law = CATALOGUE[name.strip()]
        if name.startswith("    "):
            assert above is not None
            assert (law.mechanism, law.stage) == (above.mechanism, above.stage)
        above = law


def test_the_page_of_effects_is_made_from_the_catalogue() -> None:
    settings = runpy.run_path("docs/conf.py")
    source = [Path("docs/effects.md").read_text(encoding="utf-8")]
    settings["catalogue_table"](None, "effects", source)
    listed = re.findall(r"`(\w+)` \| (?:kinematics|mechanics|tension|pressure|contact|electrical|readout)", source[0])
    assert sorted(listed) == sorted(CATALOGUE.effects)


@pytest.mark.parametrize("name", [name for name, law in CATALOGUE.effects.items() if law.strength])
def test_showcase_shows_the_effect(name: str) -> None:
    case = showcase(CATALOGUE[name])
    assert np.max(np.abs(case.with_it - case.without)) > 0.5 * VISIBLE * np.ptp(case.without)


def test_a_picture_is_what_its_name_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "load_cell_creep", "--plot", str(tmp_path / "creep.svg")]) == 0
    assert ">with load cell creep</text>" in (tmp_path / "creep.svg").read_text()  # letters, not outlines
    assert main(["effects", "drift", "--plot", str(tmp_path / "drift.gif")]) == 2
    assert "drift.gif: a figure is written as png, pdf, svg" in capsys.readouterr().err


def test_template_keeps_the_rules_and_takes_part_in_a_model(tmp_path: Path) -> None:
    write_template("my_effect", tmp_path / "mine.py")
    catalogue = load_catalogue(tmp_path / "mine.py")
    mine = catalogue["my_effect"]()
    assert check(mine) == []
    model = preset("pes") + mine
    assert model_from_dict(model.to_dict(), catalogue).effects == model.effects


def test_an_effects_file_may_have_a_dataclass_and_annotations_that_are_read_later(tmp_path: Path) -> None:
    write_template("my_effect", tmp_path / "mine.py")
    text = (tmp_path / "mine.py").read_text(encoding="utf-8").partition("import numpy")
    helper = "from dataclasses import dataclass\n\n\n@dataclass\nclass Helper:\n    size: float\n"
    lines = ["from __future__ import annotations\n\n", text[1], text[2], helper]
    (tmp_path / "mine.py").write_text("".join(lines), encoding="utf-8")
    assert check(load_catalogue(tmp_path / "mine.py")["my_effect"]()) == []


def test_template_overwrites_nothing(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("precious", encoding="utf-8")
    with pytest.raises(UserError, match="exists already"):
        write_template("my_effect", tmp_path / "mine.py")
    assert (tmp_path / "mine.py").read_text(encoding="utf-8") == "precious"


def test_a_template_is_a_python_file(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"its name must end in \.py"):
        write_template("my_effect", tmp_path / "mine.txt")
    assert not list(tmp_path.iterdir())


BROKEN = '''
import numpy as np
from testbench.knit.effect import Effect, Stage, parameter

class Bad(Effect):
    """Everything wrong.

    G = ?

    Source: none.
    Valid: never.
    """
    name = "bad"
    stage = Stage.ELECTRICAL
    reads, writes = ("conductance_S",), ("conductance_S",)
    strength = "gain"
    look = "nothing good"
    gain: float = parameter(0.1, unit="1", low=0, high=1, doc="gain")

    def apply(self, signals, dt_s):
        BODY
'''


@pytest.mark.parametrize(
    ("body", "complaint"),
    [
        ('signals["conductance_S"][:] = 1; return {"conductance_S": np.ones(3)}', "in place"),
        ('return {"conductance_S": signals["conductance_S"]}', "returns an input array"),
        ('return {"force_N": signals["conductance_S"] * 2}', "but declares"),
        ('return {"conductance_S": signals["conductance_S"][1:] * 2}', "has shape"),
        ('return {"conductance_S": np.log(self.gain * signals["conductance_S"] - 1)}', "not finite"),
        ('return {"conductance_S": signals["conductance_S"] * np.log(self.gain)}', "with gain at its bound 0"),
        ('return {"conductance_S": signals["conductance_S"] + 1e-6}', "although gain is 0"),
        ('return {"conductance_S": signals["conductance_S"] * (1 + self.gain**2)}', "nonlinear = True"),
        (
            'return {"conductance_S": signals["conductance_S"] + self.gain * np.cumsum(signals["conductance_S"])}',
            "sampling rate",
        ),
        (
            'return {"conductance_S": signals["conductance_S"] * (1 + self.gain * signals["conductance_S"][-1])}',
            "what happens later",
        ),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value", "ignore:divide by zero")
def test_a_broken_effect_is_told_which_law_it_breaks(body: str, complaint: str, tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text(BROKEN.replace("BODY", body), encoding="utf-8")
    problems = check(load_catalogue(tmp_path / "bad.py")["bad"]())
    assert any(complaint in problem for problem in problems), problems


def test_an_effect_that_would_end_the_program_does_not(tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text(BROKEN.replace("BODY", "raise SystemExit(0)"), encoding="utf-8")
    bad = load_catalogue(tmp_path / "bad.py")["bad"]()
    assert all("raises SystemExit: 0" in problem for problem in check(bad))
    time_s = np.arange(0, 5, 0.05)
    with pytest.raises(UserError, match="effect bad raised SystemExit: 0"):
        preset("pes").plus(bad).simulate(inputs(time_s, 0.1 * time_s), 0.05)


@pytest.mark.parametrize(
    ("said", "instead", "told"),
    [
        ("parameter(0.1, unit", "parameter(9.0, unit", "Bad.gain must be a number from 0 to 1, got 9"),
        ('parameter(0.1, unit="1", low=0, high=1, doc="gain")', "0.1", "amiss: gain$"),
        ("    gain: float", "    near: float", "amiss: near$"),
        ("    gain: float", "    gain: int", "amiss: gain$"),
        ("    gain: float", "    gain: str", "amiss: gain$"),
        ('strength = "gain"', 'optional_reads = ("temperature_C")', "amiss: optional_reads$"),
        ("low=0", "low=2", "finite bounds, low < high.* got scale='linear', low=2, high=1"),
        ("low=0", 'low=0, scale="log"', "above 0 with"),
        ("low=0", 'low=0, scale="Log"', "a scale of"),
        ('"bad"', '"b\\nad"', "one word of letters, digits and _; got 'b.nad'"),
        ('"bad"', "5", "one word of letters, digits and _; got 5"),
    ],
)
@pytest.mark.filterwarnings("ignore:Field name")
def test_a_class_that_cannot_be_is_refused(said: str, instead: str, told: str, tmp_path: Path) -> None:
    text = BROKEN.replace("BODY", 'return {"conductance_S": signals["conductance_S"] * 2}')
    (tmp_path / "bad.py").write_text(text.replace(said, instead), encoding="utf-8")
    with pytest.raises(UserError, match=told):
        load_catalogue(tmp_path / "bad.py")["bad"]()


def test_what_a_class_lists_as_parameters_must_be_some(tmp_path: Path) -> None:
    body = 'return {"conductance_S": signals["conductance_S"] * (1 + self.gain)}'
    text = BROKEN.replace("BODY", body).replace('look = "n', 'jumps = ("when_s",)\n    look = "n')
    (tmp_path / "bad.py").write_text(text, encoding="utf-8")
    assert check(load_catalogue(tmp_path / "bad.py")["bad"]()) == ["jumps names when_s, which is not a parameter"]


def test_weights_that_are_not_zero_by_themselves_are_tried_at_zero(tmp_path: Path) -> None:
    body = 'return {"conductance_S": signals["conductance_S"] * (1 + self.gain[0])}'
    text = BROKEN.replace("BODY", body).replace("float = parameter(0.1", "tuple[float, ...] = parameter((0.1,)")
    (tmp_path / "bad.py").write_text(text, encoding="utf-8")
    assert check(load_catalogue(tmp_path / "bad.py")["bad"]()) == []


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("return None", "returns NoneType, but declares conductance_S"),
        ('return {"conductance_S": signals["strain"] * 2}', "KeyError: 'strain is not among what it reads'"),
        ("self.gain = 3.0", "ValidationError: gain: Instance is frozen, got 3.0"),
    ],
)
def test_what_an_effect_raises_is_told_once(body: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text(BROKEN.replace("BODY", body), encoding="utf-8")
    (problem,) = check(load_catalogue(tmp_path / "bad.py")["bad"]())
    assert told in problem
    assert "\n" not in problem


def test_an_effect_that_does_not_settle_on_finer_grids_is_caught(tmp_path: Path) -> None:
    body = 'return {"conductance_S": signals["conductance_S"] + self.gain * np.random.default_rng(0).normal('
    body += 'size=signals["conductance_S"].shape)}'
    (tmp_path / "bad.py").write_text(BROKEN.replace("BODY", body), encoding="utf-8")
    assert "does not settle" in rules.converges(load_catalogue(tmp_path / "bad.py")["bad"]())


OWN = """from testbench.knit.effect import Effect

class A(Effect):
    name = "own"
"""


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("import nothing_like_this", "cannot be loaded: ModuleNotFoundError"),
        ("import sys; sys.exit(0)", "cannot be loaded: SystemExit: 0"),
        ("x = 1", "no Effect class"),
        (OWN + OWN.replace("class A", "class B"), "two effects are called own"),
        (OWN + OWN.replace('"own"', '"other"'), "two classes are called A"),
    ],
)
def test_an_effects_file_that_cannot_be_used_is_named(text: str, complaint: str, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(text, encoding="utf-8")
    with pytest.raises(UserError, match=complaint):
        load_catalogue(tmp_path / "mine.py")


def test_an_effect_of_ones_own_does_not_replace_a_built_in_one(tmp_path: Path) -> None:
    write_template("drift_of_mine", tmp_path / "mine.py")
    text = (tmp_path / "mine.py").read_text(encoding="utf-8")
    (tmp_path / "mine.py").write_text(text.replace('"drift_of_mine"', '"drift"'), encoding="utf-8")
    with pytest.raises(UserError, match="there is an effect called drift already"):
        load_catalogue(tmp_path / "mine.py")
    with pytest.raises(UserError, match="there is an effect called drift already"):
        write_template("drift", tmp_path / "drift.py")


class BrokenPlugIn:
    name = "their_effect"

    def load(self) -> None:
        raise ImportError("their library is missing")


def test_a_broken_plug_in_is_listed_and_stops_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("testbench.knit.catalogue.entry_points", lambda group: [BrokenPlugIn()])
    catalogue = load_catalogue()
    assert catalogue.broken == {"their_effect": "ImportError: their library is missing"}
    assert "broken: their_effect: ImportError: their library is missing" in catalogue_text(catalogue)
    assert "contact" in catalogue.effects


def test_a_motion_may_be_a_column_that_nobody_may_write_to() -> None:
    """As pandas gives them, counted from any row and any time."""
    time_s = np.arange(100) * 0.05
    strain = 0.1 - 0.1 * np.cos(time_s)
    plain = preset("pes").simulate(inputs(time_s, strain), 0.05)
    frame = pd.DataFrame({"time_s": time_s + 7.0, "strain": strain}, index=range(5, 105))
    told = preset("pes").simulate(inputs(frame.time_s, frame.strain), 0.05)
    np.testing.assert_allclose(told["conductance_S"], plain["conductance_S"], rtol=1e-12)


def test_a_sensor_whose_conductance_falls_needs_no_force() -> None:
    time_s = np.arange(0, 20, 0.05)
    strain = 0.15 - 0.15 * np.cos(time_s)
    effects = CATALOGUE.effects
    model = KnitModel.of(effects["piezoresistance"](), effects["shoulder_peak"](), effects["drift"]())
    out = model.simulate(inputs(time_s, strain), 0.05)
    assert np.corrcoef(strain, out["conductance_S"])[0, 1] < -0.9
    assert "force_N" not in out


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"format": "other"}, "not a knitbench model"),
        ({"version": 99}, "model version 99"),
        ({"effects": [{"name": "x", "effect": "x", "parameters": {}}]}, "no effect called x"),
        ({"effects": [{"name": "drift", "effect": "drift", "parameters": {"tau_s": -1}}]}, "Drift.tau_s must be"),
        (
            {"effects": [{"name": "drift", "effect": "drift", "parameters": {"colour": 1}}]},
            "Drift has no parameter colour",
        ),
        ({"effects": [{"name": "drift"}]}, "malformed"),
        ({"effects": [{"name": "drift", "effect": "drift", "parameters": 3}]}, "malformed"),
    ],
)
def test_a_bad_model_is_refused_in_one_sentence(change: dict[str, object], complaint: str) -> None:
    data = {**preset("pes").to_dict(), **change}
    with pytest.raises(UserError, match=complaint):
        model_from_dict(data, CATALOGUE, "model.json")


@pytest.mark.parametrize(
    ("name", "parameters", "told"),
    [
        ("stress_relaxation", {"fraction": 2}, "StressRelaxation.fraction must be a number from 0 to 1, got 2"),
        ("stress_relaxation", {"tau_s": "long"}, "StressRelaxation.tau_s must be a number from .* s, got 'long'"),
        ("stress_relaxation", {"share": 0.2}, "StressRelaxation has no parameter share; it has fraction, tau_s"),
        (
            "stress_relaxation_prony",
            {"fractions": (0, 3, 0, 0, 0, 0, 0)},
            r"fractions must be numbers from -1 to 1, got \(0.0, 3.0, 0.0",
        ),
        (
            "stress_relaxation_prony",
            {"fractions": (0.1, 0.2)},
            "StressRelaxationProny.fractions must be 7 numbers, got 2; a model of another version is to be fitted",
        ),
    ],
)
def test_a_parameter_that_cannot_be_is_refused_in_one_sentence(name: str, parameters: dict, told: str) -> None:
    with pytest.raises(UserError, match=told):
        CATALOGUE[name](**parameters)
    with pytest.raises(UserError, match=told):
        CATALOGUE[name]().replaced(**parameters)


@pytest.mark.parametrize("name", ["a.b", "a\nb", ""])
def test_a_name_that_no_address_can_have_is_refused_in_a_model(name: str) -> None:
    with pytest.raises(UserError, match="must be printable, without a point; got "):
        KnitModel({name: CATALOGUE["drift"]()})


def test_a_list_of_names_is_no_name_of_an_effect() -> None:
    with pytest.raises(UserError, match=r"the model has no effect \['drift'\]; it has "):
        preset("pes").without(["drift"])  # type: ignore[arg-type]


def test_a_model_is_a_frame_of_all_its_numbers() -> None:
    model = KnitModel.of(CATALOGUE["elasticity"](stiffness_N=7), CATALOGUE["stress_relaxation_prony"]())
    frame = model.to_frame()
    assert tuple(frame.loc["elasticity.stiffness_N"]) == (7.0, "N")
    assert tuple(frame.loc["stress_relaxation_prony.fractions[6]"]) == (0.0, "1")
    assert len(frame) == 10
    assert repr(model) == "<KnitModel elasticity + stress_relaxation_prony>"


@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_preset_is_a_plausible_knit(name: str) -> None:
    """A few newtons at 30 %, some 100 kOhm, conductance rising with stretch, force with it."""
    time_s = np.arange(0, 60, 0.05)
    strain = 0.15 - 0.15 * np.cos(2 * np.pi * time_s / 6)
    out = preset(name).simulate(inputs(time_s, strain), 0.05)
    assert 1.5 < out["force_N"].max() < 10
    assert 1e4 < np.median(1 / out["conductance_S"]) < 2e6
    assert np.corrcoef(strain, out["conductance_S"])[0, 1] > 0.4
    assert np.corrcoef(strain, out["force_N"])[0, 1] > 0.6


def test_unknown_preset_lists_what_there_is() -> None:
    assert names() == ["lycra", "pes"]
    with pytest.raises(UserError, match="there are lycra, pes"):
        preset("cotton")
    with pytest.raises(UserError, match="a specimen is a preset, @ and a whole number"):
        preset("pes@" + "9" * 5000)


def test_command_lists_shows_draws_starts_and_checks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["effects"]) == 0
    assert main(["effects", "contact", "--plot"]) == 0
    assert (tmp_path / "contact.png").read_bytes().startswith(b"\x89PNG")
    assert main(["effects", "--new", "mine"]) == 0
    assert main(["effects", "--effects", "mine.py", "--check"]) == 0
    assert "mine: keeps all rules" in capsys.readouterr().out
    broken = (tmp_path / "mine.py").read_text().replace('signals["conductance_S"] *', "1e-6 +")
    (tmp_path / "mine.py").write_text(broken)
    assert main(["effects", "--effects", "mine.py", "--check", "mine"]) == 1
    assert "although gain is 0" in capsys.readouterr().out


def test_command_refuses_an_unknown_effect(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "magic"]) == 2
    assert "no effect called magic" in capsys.readouterr().err


def test_a_guess_far_out_of_bounds_is_moved_into_them() -> None:
    catalogue = load_catalogue()
    hum = catalogue["periodic_interference"]().near(frequency_Hz=1e-9, phase_rad=100.0)
    assert (hum.model_dump()["frequency_Hz"], hum.model_dump()["phase_rad"]) == (0.02, 6.3)
    slips = catalogue["clamp_slip_events"]().near(amounts=(9.0,) + (-1.0,) * 11)
    assert slips.model_dump()["amounts"] == (0.5,) + (0.0,) * 11


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"nope": 1}, "StressRelaxation has no parameter nope; it has fraction, tau_s"),
        ({"fraction": "x"}, "StressRelaxation.fraction must be a number from 0 to 1, got 'x'"),
        ({"fraction": None}, "StressRelaxation.fraction must be a number from 0 to 1, got None"),
    ],
)
def test_a_guess_that_is_none_is_refused_in_one_sentence(changes: dict[str, object], told: str) -> None:
    with pytest.raises(UserError, match=told):
        CATALOGUE["stress_relaxation"]().near(**changes)


def test_a_guess_of_a_vector_may_be_a_list() -> None:
    guess = CATALOGUE["stress_relaxation_prony"]().near(fractions=[9.0] * 7)
    assert guess.model_dump()["fractions"] == (1.0,) * 7
