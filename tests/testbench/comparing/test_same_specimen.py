"""A held-out recording of the same specimen is judged after all that it went through, in every step."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

import testbench as tb
from testbench.cli import main
from testbench.comparing.judged import held_samples
from testbench.knit.mechanics.damage import MullinsSoftening
from testbench.recordings.between import Between
from testbench.recordings.recording import Recording
from testbench.report.overlays import as_read, overlay_of
from tests.testbench.builders import GAUGE_LENGTH_MM, PULL_S, REST_S, pulls_of, truth, write_csv


@pytest.fixture(scope="module")
def pulls() -> list[Recording]:
    """Two recordings of one specimen, which softens in the first one."""
    return pulls_of(truth().plus(MullinsSoftening(softening=0.4)), 2)


@pytest.fixture(scope="module")
def files(pulls, tmp_path_factory) -> list[str]:
    folder = tmp_path_factory.mktemp("same")
    return [write_csv(one, folder / f"{one.source}.csv") for one in pulls]


@pytest.fixture(scope="module")
def fits(files) -> dict[float | None, tb.FitResult]:
    """Of the softening model on the first; judged on the second as of a fresh specimen, and as of the same."""
    model = truth().plus(MullinsSoftening(softening=0.3))
    both = {"model": model, "gauge_length_mm": GAUGE_LENGTH_MM, "progress": False}
    return {rest_s: tb.fit(files[0], files[1], rest_s=rest_s, **both) for rest_s in (None, REST_S)}


def test_a_softened_specimen_is_no_fresh_one(fits) -> None:
    fresh, same = (fits[rest_s].errors for rest_s in (None, REST_S))
    assert same["calibration"] == fresh["calibration"]
    assert same["held_out"]["force"] < 1.3 * same["noise_floor"]["force"] < 0.3 * fresh["held_out"]["force"]


def test_every_further_step_keeps_the_rest(fits, files) -> None:
    added = tb.add(fits[REST_S], "stress_relaxation", *files, progress=False)
    assert added.file.between == Between(rest_s=REST_S)
    assert added.errors["held_out"]["force"] == pytest.approx(fits[REST_S].errors["held_out"]["force"], rel=0.1)
    assert fits[None].file.between.rest_s is None


def test_another_rest_is_asked_for_by_saying_so(fits, files) -> None:
    other = tb.fit(*files, model=fits[REST_S], rest_s=5.0, progress=False)
    assert other.file.between.rest_s == 5.0


def test_compare_and_the_pages_have_the_error_of_the_ladder(fits, files, pulls) -> None:
    expected = fits[REST_S].errors["held_out"]
    assert tb.compare(files[1], fits[REST_S]).comparison.rms == pytest.approx(expected, rel=1e-6)
    held = held_samples(fits[REST_S].file, *pulls)
    assert held.rest_s == REST_S
    assert held.counts.sum() < 0.5 * len(held.counts)


def test_where_the_first_recording_is_gone_the_other_is_judged_as_fresh_and_said_so(fits, files, tmp_path) -> None:
    gone = replace(fits[REST_S].file, fitted_on=str(tmp_path / "gone.csv"))
    found = tb.compare(files[1], gone)
    assert "judged as of a fresh specimen; it is of that of" in found.notes[0]
    assert found.comparison.rms == pytest.approx(tb.compare(files[1], fits[None]).comparison.rms, rel=1e-3)


def test_a_picture_shows_the_judged_recording_from_its_start(fits) -> None:
    held = fits[REST_S].held_out
    shown = as_read(overlay_of(held, {"model": fits[REST_S].model}, free_offset=True), held)
    assert shown.time_s[0] == pytest.approx(0.0, abs=0.2)
    assert shown.time_s[-1] == pytest.approx(PULL_S, abs=0.3)


def test_the_command_says_the_rest_once(files, tmp_path, capsys) -> None:
    model = str(tmp_path / "model.json")
    said = ["--held-out", files[1], "--gauge-length-mm", "25", "--rest-s", "30", "-o", model]
    assert main(["fit", files[0], *said]) == 0
    history = json.loads((tmp_path / "model.json").read_text())["history"]
    assert history[-1]["rest_s"] == 30
    capsys.readouterr()
    assert main(["compare", files[1], "--model", model, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["channels"]
    assert {c: one["rms"] for c, one in told.items()} == pytest.approx(history[-1]["errors"]["held_out"], rel=1e-6)


@pytest.mark.parametrize(
    ("more", "match"),
    [
        (["--rest-s", "30"], "a rest comes before that of a held-out recording, and none was given"),
        (["--rest-s", "90000", "--held-out", "B"], "--rest-s: must be more than 0 and less than 86400 s, got 90000"),
        (["--rest-s", "0", "--held-out", "B"], "must be a positive number, got '0'"),
        (["--rest-s", "30", "--held-out", "A"], "what is held out is made after a rest: give another recording"),
    ],
)
def test_a_rest_that_cannot_be_is_one_sentence(files, tmp_path, capsys, more, match) -> None:
    given = [{"A": files[0], "B": files[1]}.get(word, word) for word in more]
    try:
        code = main(["fit", files[0], *given, "--gauge-length-mm", "25", "-o", str(tmp_path / "m.json")])
    except SystemExit as end:
        code = end.code
    assert code == 2
    assert match in capsys.readouterr().err
