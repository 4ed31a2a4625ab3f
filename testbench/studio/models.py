"""The model of a campaign: where it is kept, what it was judged on, and the commands that change it."""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from nicegui import ui

from gcode.support.errors import UserError
from gcode.support.files import make_folder, write_json
from testbench.comparing.words import listed, spoken
from testbench.recordings.manifest import CSV
from testbench.recordings.recording import Recording
from testbench.results.model_file import about_model, load_model_file, same_source
from testbench.results.result_files import read_diagnosis
from testbench.studio.jobs.job import Commands
from testbench.studio.parts.starting import run_in_turn
from testbench.studio.studio import Studio

LAST_THIRD = "the last third of this recording"
BEFORE = "model-before.json"  # the one before the last baseline
LADDER = "ladder"  # in a kept diagnosis: the step that it was made of, and the name of the one that it led to
Steps = Sequence[Mapping[str, Any]]
CLOSE = 1e-6  # relative; the same errors, worked out a second time
ASKING = ("diagnose", "propose")  # jobs that look at a model, and whose answer is about that very one


def model_path(studio: Studio, c: str) -> Path:
    """``model.json`` of a campaign; it carries its whole ladder."""
    return studio.workspace.results(c) / "model.json"


def has_model(studio: Studio, c: str) -> bool:
    """Whether a campaign has been fitted."""
    return model_path(studio, c).is_file()


def diagnosis_path(studio: Studio, c: str) -> Path:
    """Where the diagnosis of a campaign is kept."""
    return studio.workspace.results(c) / "diagnosis.json"


def held_out_choices(studio: Studio, c: str) -> list[str]:
    """The last third, and campaigns of the same gauge length, which errors may be judged on; same specimen first."""
    same, others = companions(studio, c)
    return [LAST_THIRD, *same, *others]


def companions(studio: Studio, c: str) -> tuple[list[str], list[str]]:
    """Other campaigns of the same gauge length: those known to be of the same specimen, and the rest."""
    own = studio.workspace.campaign(c)
    found = [
        other
        for other in studio.workspace.campaigns()
        if other.name != c and other.gauge_length_mm == own.gauge_length_mm
    ]
    same = [other.name for other in found if own.specimen and other.specimen == own.specimen]
    return same, [other.name for other in found if other.name not in same]


def held_out_of(studio: Studio, c: str) -> str:
    """What the model of a campaign was judged on, so that its next step is judged on the same.

    Raises
    ------
    UserError
        If that is not here any more.
    """
    about = about_model(model_path(studio, c))
    kept, own = str(about.get("held_out", "")), str(about.get("fitted_on", ""))
    for name in held_out_choices(studio, c)[1:]:
        if same_source(kept, str(studio.workspace.campaign(name).folder / CSV)):
            return name
    if kept and not same_source(kept, own):
        raise UserError(
            f"the model of {c} was judged on {Path(kept).parent.name or kept}, which is not among the campaigns any "
            "more; undo its deletion, or fit the baseline anew below “Compare”"
        )
    return LAST_THIRD


def judged_on(studio: Studio, c: str) -> str:
    """The campaign whose recording the model of `c` is judged on: another, or `c` with its last third."""
    held = held_out_of(studio, c)
    return c if held == LAST_THIRD else held


def held_out_arguments(studio: Studio, held: str) -> list[str]:
    """``--held-out FOLDER``, or nothing for the last third."""
    return [] if held == LAST_THIRD else ["--held-out", str(studio.workspace.campaign(held).folder)]


def history_of(studio: Studio, c: str) -> Steps:
    """The steps of the ladder of a campaign, the first model first."""
    return list(about_model(model_path(studio, c)).get("history") or ())


def same_arguments(studio: Studio, c: str) -> list[str]:
    """What a question about the model of `c` is asked with: the model, what it is judged on, the own effects."""
    held = held_out_arguments(studio, held_out_of(studio, c))
    return ["--model", str(model_path(studio, c)), *held, *studio.effects.arguments()]


def held_out_recording(studio: Studio, c: str) -> Recording | None:
    """The other recording that the model of `c` is judged on; None for the last third of its own."""
    held = held_out_of(studio, c)
    return None if held == LAST_THIRD else studio.workspace.recording(held)


def add_command(studio: Studio, c: str, effect: str) -> tuple[str, list[str]]:
    """Put `effect` into the model of a campaign and refit."""
    argv = ["testbench", "add", effect, "--fit", str(studio.workspace.campaign(c).folder), *same_arguments(studio, c)]
    return f"Adding {spoken(effect)} and refitting", [*argv, "-o", str(model_path(studio, c))]


def diagnosed_path(studio: Studio, c: str) -> Path:
    """The model that a diagnosis ends with: what it found is put in and refitted already."""
    return studio.workspace.results(c) / "diagnosed.json"


def laws_in(studio: Studio, c: str) -> set[str]:
    """The laws that the model of a campaign has, by their names in the catalogue."""
    return {one["effect"] for one in history_of(studio, c)[-1]["model"]["effects"]}


def why_unusable(studio: Studio, c: str) -> str:
    """Why the model of a campaign cannot be used, such as an own effect that is gone; empty where it can be."""
    try:
        catalogue = studio.effects.catalogue()
        laws = {one["effect"] for step in history_of(studio, c) for one in step["model"]["effects"]}
        if gone := sorted(laws - set(catalogue.effects)):
            return f"The model of {c} needs what is not among the effects here: {listed(gone)}."
        held_out_of(studio, c)
        load_model_file(model_path(studio, c), catalogue)
    except UserError as error:
        return str(error)
    return ""


def step_diagnosis(studio: Studio, c: str, step: int) -> Path:
    """Where the diagnosis that led to step number `step` of the ladder is kept."""
    return studio.workspace.results(c) / "diagnoses" / f"step-{step}.json"


def keep_diagnosis(studio: Studio, c: str, diagnosis: Mapping[str, Any], before: Steps, led_to: str) -> None:
    """Keep the diagnosis for which the step `led_to` was put on top of the steps `before`, and that it was so."""
    target = step_diagnosis(studio, c, len(before))
    make_folder(target.parent)
    write_json(target, {**diagnosis, LADDER: _rung(before[-1], led_to)})


def _rung(after: Mapping[str, Any], led_to: str) -> dict[str, Any]:
    """Where on a ladder a step was taken; what was told of the fit of the one below stands there from then on."""
    return {"after": {key: value for key, value in after.items() if key != "fit"}, "led_to": led_to}


def kept_diagnoses(studio: Studio, c: str) -> dict[int, Path]:
    """The diagnoses that led to the steps of the ladder as it is now, by the number of the first step."""
    if not has_model(studio, c):
        return {}
    history, found = history_of(studio, c), {}
    for step in range(1, len(history)):
        path = step_diagnosis(studio, c, step)
        told = _rung(history[step - 1], history[step]["step"])
        if path.is_file() and read_diagnosis(path).get(LADDER) == told:  # it may be of a ladder that is no more
            found[step] = path
    return found


def is_fresh(studio: Studio, c: str, diagnosis: Mapping[str, Any] | None = None) -> bool:
    """Whether a diagnosis was made of the model of a campaign as it is now; of the kept one, if none is given."""
    if not has_model(studio, c):
        return False
    if diagnosis is None:
        if not diagnosis_path(studio, c).is_file():
            return False
        diagnosis = read_diagnosis(diagnosis_path(studio, c))
    begun = list(diagnosis.get("history") or ())
    return bool(begun) and is_last(about_model(model_path(studio, c)), begun[0])


def is_last(model: Mapping[str, Any], begun: Mapping[str, Any]) -> bool:
    """Whether the step that a diagnosis or a proposal began with is the last one of the ladder in a model's file.

    It is told by content: a job that began before the model was changed, and ended after, leaves a newer file. Noise
    floors tell the samples that it was judged on. A last step without a fit is what is left after one was taken back:
    whoever asks fits it once more, and only its effects stay the same.
    """
    steps = model.get("history") or ()
    if not steps:
        return False
    last = steps[-1]
    if not _close(begun["noise_floor"], last["noise_floor"]):
        return False
    if not model.get("fit"):
        return _effects(begun) == _effects(last)
    return begun["model"] == last["model"] and _close(begun["errors"]["held_out"], last["errors"]["held_out"])


def _close(some: Mapping[str, float], others: Mapping[str, float]) -> bool:
    return some.keys() == others.keys() and all(math.isclose(some[key], others[key], rel_tol=CLOSE) for key in some)


def _effects(step: Mapping[str, Any]) -> set[tuple[str, str]]:
    return {(one["name"], one["effect"]) for one in step["model"]["effects"]}


def refuse_while_asked(studio: Studio, c: str) -> None:
    """Raise `UserError` while a question about the model of `c` is open: its answer would be about another model."""
    for kind in ASKING:
        if running := studio.jobs.under_way(f"{kind}:{c}"):
            raise UserError(
                f"{running.title}: this is still under way, and the model of {c} must stay as it is until it has "
                "ended; wait for it, or stop it"
            )


def adopt_diagnosed(studio: Studio, c: str, diagnosis: Mapping[str, Any]) -> None:
    """Put the steps of a diagnosis on top of the campaign's own ladder.

    Raises
    ------
    UserError
        If a model file is missing, damaged or not of this diagnosis, or a question about the model is open.
    """
    from testbench.comparing.ladder import continued

    refuse_while_asked(studio, c)
    catalogue = studio.effects.catalogue()
    mine = load_model_file(model_path(studio, c), catalogue)
    found = load_model_file(diagnosed_path(studio, c), catalogue)
    same_answer = list(found.history) == list(diagnosis.get("history") or [])
    same_judge = found.held_out == mine.held_out or same_source(found.held_out, mine.held_out)
    if not (same_answer and same_judge and is_fresh(studio, c, diagnosis)):
        raise UserError(f"{c}: the model or the diagnosis has changed since; ask again what is missing")
    continued(mine, found).save(model_path(studio, c))
    copied = shlex.join(["cp", str(diagnosed_path(studio, c)), str(model_path(studio, c))])
    above = f"  # its steps on top of the {len(mine.history)} that were there" if len(mine.history) > 1 else ""
    studio.keep_command(c, copied + above)
    if len(found.history) > 1:
        keep_diagnosis(studio, c, diagnosis, mine.history, found.history[1]["step"])


def check_is_lacking(studio: Studio, c: str, laws: Sequence[str]) -> list[str]:
    """Those of `laws` that the model does not have; `UserError` where it has all of them."""
    wanted = [law for law in laws if law not in laws_in(studio, c)]
    if not wanted:
        names = " and ".join(spoken(law) for law in laws)
        raise UserError(f"{names}: it is in the model of {c} already; ask again to see what is missing now")
    return wanted


def add_laws(
    studio: Studio,
    c: str,
    laws: Sequence[str],
    diagnosis: Mapping[str, Any],
    holder: ui.column,
    done: Callable[[], None],
) -> None:
    """Put laws that a diagnosis asks for into the model, one after the other; it is kept where it is of this model.

    Raises
    ------
    UserError
        If all of them are in already, or a question about the model is open.
    """
    wanted = check_is_lacking(studio, c, laws)
    refuse_while_asked(studio, c)
    if is_fresh(studio, c, diagnosis) and not studio.jobs.under_way(f"model:{c}"):
        # It is shown once there is such a step.
        keep_diagnosis(studio, c, diagnosis, history_of(studio, c), f"+ {wanted[0]}")
    change_model(studio, c, [add_command(studio, c, law) for law in wanted], holder, done)


def change_model(studio: Studio, c: str, commands: Commands, holder: ui.column, done: Callable[[], None]) -> None:
    """Run commands that change the model of a campaign; see `run_in_turn`.

    Raises
    ------
    UserError
        While a question about the model is open.
    """
    refuse_while_asked(studio, c)
    run_in_turn(studio, f"model:{c}", commands, holder, done)
