"""A report is one safe, self-contained file; its figures come out for a paper; bad input is one sentence."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from pathlib import Path

import numpy as np
import pytest

import tests.testbench.report.samples as samples
from gcode.support.errors import UserError
from testbench.cli import main
from testbench.recordings.files import write_recording_csv
from testbench.report import sections
from testbench.report.document import Picture, Report, Section, Table
from testbench.report.figures import ladder_figures, recording_figures
from testbench.report.writing.packing import plotly_path, to_json
from testbench.report.writing.page import to_html
from testbench.report.writing.static import write_figure
from testbench.report.writing.write import write_report

PLOTLY_SHA256 = "7c593b9eda0e74a1d07335cf89cbf7a55ffc114909980c3729af835453bdb02a"  # npm, cartesian-dist-min 3.7.0


def whole_report() -> Report:
    both, steps, compared = samples.overlay(), samples.steps(), samples.comparison()
    glance = Picture("glance", ladder_figures.at_a_glance(both, steps, (20.0, 60.0)), "measured and modelled")
    parts = [
        sections.recording_section(samples.recording(), "Recording <b>one</b>", "recording-1"),
        sections.comparison_section(both, compared, compared.maps),
        sections.ladder_section(steps),
        sections.compensator_section(samples.score()),
        sections.diagnosis_section(samples.diagnosis()),
    ]
    return Report("A </script> title", "It fits.", [glance], parts, "footer")


def test_page_is_self_contained_and_small() -> None:
    page = to_html(whole_report())
    assert len(page.encode()) <= 6_000_000
    markup = re.sub(r"<script>.*?</script>", "", page, flags=re.S)
    assert not re.search(r"""(src|href)=["'](?!#)""", markup)
    assert "default-src 'none'" in page


def test_recordings_of_one_name_have_a_link_each() -> None:
    page = to_html(Report("T", "V", [], [Section("Recording one"), Section("Recording one")]))
    links = re.findall(r'href="#([^"]+)"', page)
    assert len(set(links)) == 2
    assert links == re.findall(r'<section id="([^"]+)"', page)


def test_every_picture_has_its_place_and_its_data() -> None:
    report = whole_report()
    page = to_html(report)
    names = [picture.name for picture in report.pictures()]
    assert len(names) == len(set(names)) == 15
    data = re.search(r'<script type="application/json" id="figures">(.*?)</script>', page, flags=re.S)
    assert data is not None
    assert set(json.loads(data.group(1))) == {*names, "config"}
    for name in names:
        assert f'id="{name}"' in page


def test_an_error_without_a_place_is_not_called_noise() -> None:
    compared = samples.comparison(worst=())
    said = sections.comparison_section(samples.overlay(), compared, compared.maps).items
    assert "The error of the force and the conductance is spread out or in a few peaks: no single place can be " in (
        next(item for item in said if isinstance(item, str))
    )


def test_text_cannot_become_markup() -> None:
    page = to_html(whole_report())
    assert "<title>A &lt;/script&gt; title</title>" in page
    assert "Recording &lt;b&gt;one&lt;/b&gt;" in page


def test_plotly_is_the_file_that_was_published() -> None:
    assert hashlib.sha256(plotly_path().read_bytes()).hexdigest() == PLOTLY_SHA256


def test_arrays_are_packed_as_float32() -> None:
    value = json.loads(to_json({"y": np.array([0.5, -1.25]), "name": "force"}))
    assert np.frombuffer(base64.b64decode(value["y"]["bdata"]), "<f4").tolist() == [0.5, -1.25]
    assert to_json([np.array([[1.0, np.nan]]), np.int64(2), np.array(["a"])]) == '[[[1.0,null]],2,["a"]]'


def test_markdown_names_every_figure_that_was_written(tmp_path: Path) -> None:
    report = Report("T", "V", [], [Section("S", ["text", Table(("a", "b"), [("1|2", "3")]), _ladder_picture()])], "f")
    write_report(report, tmp_path / "my r.md", "md")
    text = (tmp_path / "my r.md").read_text()
    assert "| 1\\|2 | 3 |" in text
    assert "(my%20r-figures/ladder.png)" in text, "a blank would end the link"
    assert (tmp_path / "my r-figures" / "ladder.png").stat().st_size > 5_000
    assert (tmp_path / "my r-figures" / "ladder.pdf").read_bytes().startswith(b"%PDF")
    assert "*the ladder*" in text


def _ladder_picture() -> Picture:
    return Picture("ladder", ladder_figures.ladder(samples.steps()), "the ladder")


def test_same_figure_gives_the_same_bytes(tmp_path: Path) -> None:
    figure = recording_figures.time_series(samples.recording())
    for suffix in ("png", "pdf", "svg"):
        for name in ("a", "b"):
            write_figure(figure, tmp_path / f"{name}.{suffix}")
        assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()


def test_unknown_figure_format_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"written as png, pdf, svg; got 'gif'"):
        write_figure(recording_figures.time_series(samples.recording()), tmp_path / "a.gif")


def test_unknown_trace_is_refused_not_dropped(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="figures of type pie cannot be drawn"):
        write_figure({"data": [{"type": "pie"}], "layout": {"height": 100}}, tmp_path / "a.png")


def test_command_writes_a_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_recording_csv(tmp_path / "mine.csv", samples.recording())
    arguments = ["--recording", str(tmp_path / "mine.csv"), "--gauge-length-mm", "25", "-o", str(tmp_path / "r.html")]
    assert main(["report", *arguments]) == 0
    assert "<h1>mine</h1>" in (tmp_path / "r.html").read_text()
    assert "wrote" in capsys.readouterr().out


def test_command_takes_a_score_alone_and_refuses_another_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "score.json").write_text(json.dumps(samples.score()))
    (tmp_path / "other.json").write_text("{}")
    output = ["-o", str(tmp_path / "r.html")]
    assert main(["report", "--compensator", str(tmp_path / "score.json"), *output]) == 0
    assert "The compensator" in (tmp_path / "r.html").read_text()
    assert main(["report", "--compensator", str(tmp_path / "other.json"), *output]) == 2
    assert "not a score" in capsys.readouterr().err


def test_the_whole_story_from_a_fitted_model(tmp_path: Path) -> None:
    source = samples.recording(1200)
    write_recording_csv(tmp_path / "mine.csv", source)
    recording = [str(tmp_path / "mine.csv"), "--gauge-length-mm", "25"]
    model = str(tmp_path / "model.json")
    assert main(["fit", *recording, "-o", model]) == 0
    assert main(["report", "--recording", *recording, "--model", model, "-o", str(tmp_path / "r.html")]) == 0
    page = (tmp_path / "r.html").read_text()
    for words in (
        "no effect has been added yet",
        'id="at-a-glance"',
        "Where the model fails",
        "elasticity: stiffness",
    ):
        assert words in page


def test_a_report_says_when_from_what_and_by_which_commands(tmp_path: Path) -> None:
    source = tmp_path / "mine.csv"
    write_recording_csv(source, samples.recording())
    commands = tmp_path / "commands.txt"
    commands.write_text("2026-11-22 17:05  testbench fit mine -o model.json\n\ntestbench diagnose mine\n")
    arguments = ["--recording", str(source), "--gauge-length-mm", "25", "--commands", str(commands)]
    assert main(["report", *arguments, "-o", str(tmp_path / "r.html")]) == 0
    page = (tmp_path / "r.html").read_text()
    assert re.search(r"knitbench report · \d{1,2} \w+ 20\d\d, \d\d:\d\d", page)
    assert hashlib.sha256(source.read_bytes()).hexdigest() in page
    assert "<td>2026-11-22 17:05</td><td>testbench fit mine -o model.json</td>" in page
    assert "<td></td><td>testbench diagnose mine</td>" in page
    assert main(["report", *arguments[:-1], str(tmp_path), "-o", str(tmp_path / "r.html")]) == 2


def test_each_step_has_the_diagnosis_that_led_to_it(tmp_path: Path) -> None:
    write_recording_csv(tmp_path / "mine.csv", samples.recording(1200))
    recording, model = [str(tmp_path / "mine.csv"), "--gauge-length-mm", "25"], tmp_path / "model.json"
    assert main(["fit", *recording, "-o", str(model)]) == 0
    fitted = json.loads(model.read_text())
    taken = samples.diagnosis() | {"history": fitted["history"]}
    taken["model_after"] = {name: fitted[name] for name in ("format", "version", "effects")}
    taken["ranking"][0]["law"] = "hysteresis"  # it is in the model
    fitted["history"] += [fitted["history"][0] | {"step": f"+ {law}"} for law in ("hysteresis", "drift")]
    model.write_text(json.dumps(fitted))
    open_still = samples.diagnosis("nothing_missing")
    names = []
    for name, data in (("one", taken), ("two", open_still)):
        (tmp_path / name).write_text(json.dumps(data))
        names += ["--diagnosis", str(tmp_path / name)]
    output = str(tmp_path / "r.html")
    assert main(["report", "--recording", *recording, "--model", str(model), *names, "-o", output]) == 0
    page = Path(output).read_text()
    assert "Why stress relaxation was added" in page
    assert "What is missing now" in page
    assert "With hysteresis and drift the held-out error of the force goes from" in page
    assert "Nothing is missing that these recordings could show (92 %)." in page
    assert 'id="candidates"' in page
    assert 'id="candidates-2"' in page


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "nothing to report"),
        (["--recording", "absent.csv", "--gauge-length-mm", "25"], "no such recording"),
    ],
)
def test_bad_input_is_one_sentence(arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", *arguments]) == 2
    assert sentence in capsys.readouterr().err
