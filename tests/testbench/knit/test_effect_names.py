"""Names that an effect may have: those of a Python class, and of no other effect or hypothesis."""

from __future__ import annotations

from pathlib import Path

import pytest

from gcode.support.errors import UserError
from testbench.cli import main
from testbench.knit.catalogue import load_catalogue
from testbench.knit.effect import Effect
from testbench.knit.effect_names import HYPOTHESES, check_name, class_name
from testbench.knit.template import write_template


@pytest.mark.parametrize("name", ["true", "none", "false", "_", "__", "_2", "a b", "My", "", "class", "1st", "é-"])
def test_a_name_that_makes_no_class_is_refused(name):
    with pytest.raises(UserError, match=r"f.py: an effect is named after its file, .* got "):
        check_name(name, "f.py", ())


@pytest.mark.parametrize("name", ["effect", "stage"])
def test_a_class_would_hide_what_its_file_imports(name):
    with pytest.raises(UserError, match=f"imports {class_name(name)}"):
        check_name(name, "f.py", ())


def test_a_good_name_is_one():
    check_name("my_effect_2", "my_effect_2.py", ("drift",))
    assert class_name("my_effect_2") == "MyEffect2"


@pytest.mark.parametrize("name", HYPOTHESES)
def test_no_effect_is_called_as_a_hypothesis(name: str, tmp_path: Path):
    with pytest.raises(UserError, match=f"a diagnosis has a hypothesis called {name}"):
        write_template(name, tmp_path / f"{name}.py")
    write_template("mine", tmp_path / "mine.py")
    text = (tmp_path / "mine.py").read_text(encoding="utf-8")
    (tmp_path / "mine.py").write_text(text.replace('name = "mine"', f'name = "{name}"'), encoding="utf-8")
    with pytest.raises(UserError, match=rf"mine.py: a diagnosis has a hypothesis called {name}"):
        load_catalogue(tmp_path / "mine.py")


def test_no_mechanism_is_called_as_a_hypothesis():
    catalogue = load_catalogue()
    other = type("Other", (Effect,), {"name": "other", "mechanism": "unknown"})
    with pytest.raises(UserError, match="a hypothesis called unknown"):
        catalogue.add(other, "effects")


def test_a_second_effects_file_is_refused_and_not_dropped(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as caught:
        main(["effects", "--effects", "a.py", "--effects", "b.py"])
    assert caught.value.code == 2
    assert "--effects was given twice; put all classes of your own into one file" in capsys.readouterr().err


def test_the_names_of_all_laws_must_be_free(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    write_template("law_2", tmp_path / "mine.py")
    words = ["propose", "no.csv", "--effects", str(tmp_path / "mine.py"), "-o", str(tmp_path / "law.py"), "--laws"]
    assert main([*words, "2"]) == 2
    assert "there is an effect called law_2 already" in capsys.readouterr().err
