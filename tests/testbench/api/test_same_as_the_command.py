"""The public functions and the commands give the same on the same files."""

from __future__ import annotations

import json
import threading
from contextlib import contextmanager

import numpy as np
import pytest

import gcode
import testbench as tb
from gcode.support.errors import UserError
from gcode.support.files import write_json
from testbench.campaigns.plan import Plan
from testbench.cli import main
from testbench.fitting import constants
from testbench.rig.connection.parts import paced
from testbench.rig.connection.serial_port import open_port
from testbench.rig.simulation.played import played
from testbench.rig.simulation.pty_port import PtyPort, serve
from tests.testbench.api.samples import diagnosed, fitted, relaxed
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


def test_one_model_has_one_error_on_one_recording(monkeypatch):
    """What `diagnose` says of the model that it was given is what `fit` and `compare` say of it."""
    fit = fitted()
    for spent in ("BENDING", "STIFF"):
        monkeypatch.setattr(constants, spent, 0)  # what may be missing does not matter here
    found = tb.diagnose(relaxed(), model=fit, most=1, progress=False).diagnosis
    compared = tb.compare(relaxed(), fit).comparison.rms
    assert dict(found.error_before) == pytest.approx(fit.file.history[-1]["errors"]["held_out"], rel=1e-9)
    assert {channel: compared[channel] for channel in found.error_before} == pytest.approx(dict(found.error_before))
    assert found.before.model.to_dict() == fit.model.to_dict()


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


def test_simulate_takes_the_text_of_a_program_as_check_and_play_do():
    made = gcode.generate("paper-1", seed=3, duration_s=20)
    text, whole = tb.simulate("pes", made.program), tb.simulate("pes", made)
    assert text.to_dict()["columns"] == whole.to_dict()["columns"]
    assert text.source.startswith("simulated program.tap, seed of noise 1 (")


def test_run_keeps_the_bytes_that_the_command_keeps_and_makes_them_once(tmp_path, capsys):
    gcode.generate("paper-1", seed=3, duration_s=60).write(tmp_path)
    program, theirs = str(tmp_path / "program.tap"), tmp_path / "theirs"
    words = [
        "run",
        "--sensor",
        "pes@2",
        "--program",
        program,
        "--seed",
        "7",
        "--room-swing-c",
        "2",
        "-o",
        str(theirs),
    ]
    assert main([*words, "-o", str(theirs)]) == 0
    tools = tb.Instruments(room={"swing_C": 2.0})
    mine = tb.run("pes@2", program, tmp_path / "mine", seed=7, instruments=tools)
    assert capsys.readouterr().out == f"{mine}\n".replace("mine", "theirs")
    names = sorted(path.name for path in theirs.iterdir())
    assert names == sorted(path.name for path in mine.folder.iterdir())
    assert all((theirs / name).read_bytes() == (mine.folder / name).read_bytes() for name in names)
    again = tb.run("pes@2", program, theirs, seed=7, instruments=tools)
    assert again.status is None
    assert again.ended_well


def test_a_second_run_of_a_sensor_remembers_the_campaign_before(tmp_path):
    program = gcode.generate("paper-1", seed=3, duration_s=30)
    first = tb.run(tb.preset("pes"), program, tmp_path / "first")
    second = tb.run(tb.preset("pes"), program, tmp_path / "second", after=[first.folder]).recording
    assert np.array_equal(second["force_N"], tb.simulate(tb.preset("pes"), program, after=[first.folder])["force_N"])
    assert not np.array_equal(second["force_N"], first.recording["force_N"])
    with pytest.raises(UserError, match="cannot replace a campaign that this one is made from"):
        tb.run(tb.preset("pes"), program, first.folder, after=[first.folder], overwrite=True)
    with pytest.raises(UserError, match="a campaign of another sensor"):
        tb.simulate(tb.preset("lycra"), program, after=[first.folder])


def test_what_a_run_reads_is_not_replaced_by_it(tmp_path):
    program = gcode.generate("paper-1", seed=3, duration_s=10)
    first = tb.run("pes", program, tmp_path / "first").folder
    kept = {path.name: path.read_bytes() for path in first.iterdir()}
    for source in ({"program": first / "program.tap"}, {"program": program, "after": [first / "program.tap"]}):
        with pytest.raises(UserError, match=r"cannot replace a campaign that this one is made from \(.*program\.tap"):
            tb.run("pes", **source, folder=first, seed=2, overwrite=True)
    assert {path.name: path.read_bytes() for path in first.iterdir()} == kept


def test_a_run_that_fails_leaves_the_campaign_that_it_was_to_replace(tmp_path):
    program = gcode.generate("paper-1", seed=3, duration_s=10)
    first = tb.run("pes", program, tmp_path / "first").folder
    kept = {path.name: path.read_bytes() for path in first.iterdir()}
    hot = tb.Instruments(room={"mean_C": 1e7})
    with pytest.raises(UserError, match="lines was accepted"):
        tb.run("pes", program, first, instruments=hot, overwrite=True)
    assert {path.name: path.read_bytes() for path in first.iterdir()} == kept
    assert [path.name for path in tmp_path.iterdir()] == ["first"]


def test_an_aligned_campaign_is_aligned_again_in_its_place(tmp_path):
    folder = tb.run("pes", gcode.generate("paper-1", seed=3, duration_s=60), tmp_path / "knit").folder
    aligned = tb.align(folder).write(tmp_path / "aligned")
    tb.align(aligned).write(aligned, overwrite=True)
    assert tb.read(aligned).has("displacement_planned_mm")


def test_align_writes_the_campaign_that_the_command_writes(tmp_path, capsys):
    program = gcode.generate("paper-1", seed=3, duration_s=60)
    folder = tb.run(tb.preset("pes"), program, tmp_path / "knit").folder
    assert main(["align", str(folder), "-o", str(tmp_path / "theirs")]) == 0
    found = tb.align(folder)
    assert capsys.readouterr().out.startswith("".join(f"{folder}: {words}\n" for words in found.words))
    found.write(tmp_path / "mine")
    for name in ("recording.csv", "program.tap", "datapackage.json"):
        assert (tmp_path / "mine" / name).read_bytes() == (tmp_path / "theirs" / name).read_bytes()
    assert np.array_equal(tb.align(tb.read(folder), program).recording.time_s, found.recording.time_s)
    assert len(found.plot().lines) == 2
    with pytest.raises(UserError, match="only a campaign's folder knows its own"):
        tb.align(tb.read(folder))
    with pytest.raises(UserError, match="no such program"):
        tb.align(folder, tmp_path / "none.tap")
    assert tb.align(folder, program.program).alignment == found.alignment
    with pytest.raises(UserError, match=r"program: must be what .*, or the path of one, got Program"):
        tb.align(folder, gcode.read(folder / "program.tap"))
    (tmp_path / "bare").mkdir()
    (tmp_path / "bare" / "recording.csv").write_bytes((folder / "recording.csv").read_bytes())
    with pytest.raises(UserError, match=r"holds no program\.tap; name the program that was played"):
        tb.align(tmp_path / "bare" / "recording.csv", gauge_length_mm=25)


def test_dataset_makes_what_the_command_makes(tmp_path, capsys):
    gcode.generate("paper-1", seed=3, duration_s=30).write(tmp_path)
    spec = tmp_path / "knits.toml"
    spec.write_text('sensors = ["pes@1", "pes@2"]\nprograms = ["*.tap"]\nseeds = "1-2"\n')
    assert main(["dataset", str(spec), "-o", str(tmp_path / "theirs"), "--workers", "1"]) == 0
    told = []
    mine = tb.dataset(spec, tmp_path / "mine", workers=1, progress=lambda done, total: told.append((done, total)))
    assert (len(mine), mine.made, mine.there) == (4, 4, 0)
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert capsys.readouterr().out.startswith(f"{mine}, ".replace("mine", "theirs"))
    frame = mine.to_frame()
    assert frame.equals(tb.dataset(spec, tmp_path / "theirs", workers=1, progress=False).to_frame())
    assert (frame.samples > 0).all()
    with pytest.raises(UserError, match="format: must be one of csv, parquet, got 'xlsx'"):
        tb.dataset(spec, tmp_path / "mine", format="xlsx")


def test_import_file_writes_the_campaign_that_the_command_writes(tmp_path, capsys):
    file = tmp_path / "lab.csv"
    file.write_text("Zeit [s];Weg [cm];Kraft [mN]\n0,0;0,0;0\n0,1;0,5;900\n0,2;1,0;1800\n")
    assert main(["import", str(file), "--gauge-length-mm", "40", "-o", str(tmp_path / "theirs")]) == 0
    said = capsys.readouterr().out
    found = tb.import_file(file, tb.Wish(gauge_length_mm=40))
    assert found.write(tmp_path / "mine") == (tmp_path / "mine",)
    assert said == f"{found.words(tmp_path / 'theirs')}\n"
    for name in ("recording.csv", "datapackage.json"):
        assert (tmp_path / "mine" / name).read_bytes() == (tmp_path / "theirs" / name).read_bytes()
    assert main(["import", str(file), "--gauge-length-mm", "40", "--json", "-o", str(tmp_path / "more")]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told == json.loads(json.dumps(found.to_dict(tmp_path / "more")))
    with pytest.raises(UserError, match="the gauge length is not known"):
        tb.import_file(file)
    with pytest.raises(UserError, match=r"gauge_length_mm: is 30 mm, and the wish says 40 mm; say one of them"):
        tb.import_file(file, tb.Wish(gauge_length_mm=40), gauge_length_mm=30)


def test_verify_says_what_the_command_says(tmp_path, capsys):
    done = tb.run(tb.preset("pes"), gcode.generate("paper-1", seed=3, duration_s=30), tmp_path / "knit")
    assert main(["verify", "--again", str(done.folder)]) == 0
    assert capsys.readouterr().out == f"{tb.verify(done.folder, again=True)}\n"
    (done.folder / "events.jsonl").write_text("changed")
    assert main(["verify", str(done.folder)]) == 1
    found = tb.verify(done.folder)
    assert capsys.readouterr().err == "".join(f"{problem}\n" for problem in found.problems)
    assert found.to_frame().intact.tolist() == [False]
    with pytest.raises(UserError, match="none: no such campaign folder"):
        tb.verify(tmp_path / "none")


def test_hide_writes_the_files_of_the_command_and_tells_the_truth_when_asked(tmp_path, capsys):
    words = ["hide", "--effect", "clamp_slip", "--seed", "3", "--minutes", "2", "--rate-hz", "20"]
    assert main([*words, "-o", str(tmp_path / "theirs")]) == 0
    case = tb.hide("clamp_slip", tmp_path / "mine", seed=3, minutes=2, rate_hz=20)
    assert capsys.readouterr().out == f"{case}\n".replace("mine", "theirs")
    for name in ("recordings/held_out.csv", "sealed/truth.json"):
        assert (tmp_path / "mine" / name).read_bytes() == (tmp_path / "theirs" / name).read_bytes()
    assert case.truth["effects"][0]["effect"] == "clamp_slip"
    assert len(case.calibration) > 2000


def test_record_keeps_what_the_command_keeps(tmp_path, capsys, monkeypatch):
    gcode.generate("paper-1", seed=3, duration_s=20).write(tmp_path)
    program, theirs, mine = str(tmp_path / "program.tap"), tmp_path / "theirs", tmp_path / "mine"
    with served_rig(program, monkeypatch) as port:
        words = ["--port", port, "--program", program, "--specimen", "knit 7", "-o", str(theirs)]
        assert main(["record", *words]) == 0
    said = capsys.readouterr().out
    with served_rig(program, monkeypatch) as port:
        done = tb.record(port, program, mine, specimen="knit 7")
    assert done.ended_well
    assert said == f"{done}\n".replace("mine", "theirs")
    for name in ("recording.csv", "events.jsonl", "program.tap"):
        assert (mine / name).read_bytes() == (theirs / name).read_bytes()
    with pytest.raises(UserError, match="this recording is complete"):
        tb.resume_recording(done.folder)


@contextmanager
def served_rig(program, monkeypatch):
    """The simulated rig behind a pseudo-terminal, many times faster than real; the name of its port.

    To open a port takes a while, in which it is there and its buffer is then emptied: the rig speaks only afterwards,
    so that every recorder hears its first line.
    """
    motion, gauge_length_mm = played(program, None)
    lines = Plan(program, tb.preset("pes"), gauge_length_mm, 1, "pes").wire_lines(motion)
    port, opened = PtyPort(), threading.Event()

    def open_and_tell(*args):
        found = open_port(*args)
        opened.set()
        return found

    def spoken():
        assert opened.wait(60)
        yield from paced(lines, 200.0)

    worker = threading.Thread(target=lambda: serve(port, spoken()))
    worker.start()
    with monkeypatch.context() as patched:
        patched.setattr("testbench.rig.connection.serial_port.open_port", open_and_tell)
        yield port.name
    worker.join(60)
    port.close()


def test_make_report_writes_the_page_of_the_command(file, tmp_path, monkeypatch):
    monkeypatch.setattr("testbench.report.build.moment", lambda: "today")
    fitted().save(tmp_path / "model.json")
    write_json(tmp_path / "found.json", diagnosed().to_dict())
    model, found, theirs = str(tmp_path / "model.json"), str(tmp_path / "found.json"), tmp_path / "theirs.html"
    words = ["report", "--recording", file, "--gauge-length-mm", "25", "--model", model, "--diagnosis", found]
    assert main([*words, "-o", str(theirs)]) == 0
    tb.make_report(file, model=model, diagnoses=found, gauge_length_mm=25).write(tmp_path / "mine.html")
    assert (tmp_path / "mine.html").read_text() == theirs.read_text()
    objects = tb.make_report(relaxed(), model=fitted(), diagnoses=diagnosed())
    assert objects.verdict == tb.make_report(file, model=model, diagnoses=found, gauge_length_mm=25).verdict
    assert objects.report.sections[-1].items == ["All of it was given in memory: no file is known."]


@pytest.mark.slow
def test_next_experiment_gives_what_the_command_writes(file, tmp_path):
    rivals = {}
    for effect in (tb.effects.StressRelaxation(), tb.effects.LoadCellCreep()):
        model = tb.fit(file, gauge_length_mm=25, progress=False).model + effect
        rivals[effect.name] = tb.fit(file, model=model, gauge_length_mm=25, progress=False)
        rivals[effect.name].save(tmp_path / f"{effect.name}.json")
    paths, out = [str(tmp_path / f"{name}.json") for name in rivals], tmp_path / "next.json"
    assert main(["experiment", *paths, "--duration-s", "120", "--json", str(out)]) == 0
    mine = tb.next_experiment(rivals, bounds={"duration_s": 120}, progress=False)
    assert json.loads(json.dumps(mine.to_dict())) == json.loads(out.read_text())
