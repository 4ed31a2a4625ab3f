"""A law that `testbench propose` has written for a campaign: where it is kept, and how it is taken into use."""

from __future__ import annotations

import re
import shlex
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from gcode.support.errors import UserError
from gcode.support.files import make_folder, write_text
from gcode.support.strict import ExtraIgnored, load, read_text
from testbench.recordings.stored import Finite, Label, Remark
from testbench.results.model_file import Step, about_model, load_model_file
from testbench.results.result_files import read_diagnosis
from testbench.studio import models
from testbench.studio.studio import Studio

FOLDER = "proposal"  # below the results of a campaign
JSON, MODEL = "proposal.json", "model.json"
LARGEST_EFFECT_BYTES = 1 << 20


class Option(ExtraIgnored):
    """A law that was refitted, as ``testbench propose --json`` tells it."""

    words: Remark
    latex: Remark
    parameters: dict[Label, Finite]
    units: dict[Label, Label]
    meanings: dict[Label, Remark] = Field(default_factory=dict)
    log_evidence: Finite
    gains_in: Finite
    best_in: Finite


class FoundLaw(Option):
    """A law that was proposed, and what else could be it."""

    effect: Label
    tied: int = 0
    alternatives: Annotated[list[Option], Field(max_length=50)] = Field(default_factory=list)


class Proposal(ExtraIgnored):
    """The file that ``testbench propose --json`` writes, as far as a page shows it."""

    verdict: Literal["proposed", "nothing_left", "no_law", "does_not_hold"]
    laws: Annotated[list[FoundLaw], Field(max_length=20)]
    rejected: Option | None = None
    not_judged: Annotated[list[Remark], Field(max_length=50)]
    error_before: dict[Label, Finite]
    error_after: dict[Label, Finite]
    noise_floor: dict[Label, Finite]
    history: Annotated[list[Step], Field(max_length=1000)] = Field(default_factory=list)


@dataclass(frozen=True)
class Kept:
    """A proposal of a campaign and its files.

    Attributes
    ----------
    found : Proposal
    folder : Path
    code : str
        The effect file as it will be put to use; empty where no law was proposed.
    fresh : bool
        Whether it was made of the model as it is now.
    """

    found: Proposal
    folder: Path
    code: str
    fresh: bool

    @property
    def picture(self) -> Path | None:
        """The picture, where there is one."""
        path = self.folder / f"{self.found.laws[0].effect}.png" if self.found.laws else None
        return path if path is not None and path.is_file() else None


def folder_of(studio: Studio, c: str) -> Path:
    """Where the last proposal of a campaign is kept."""
    return studio.workspace.results(c) / FOLDER


def kept_proposal(studio: Studio, c: str) -> Kept | None:
    """The last proposal of a campaign; None where there is none.

    Raises
    ------
    UserError
        If it is damaged.
    """
    folder = folder_of(studio, c)
    if not (folder / JSON).is_file():
        return None
    found = load(folder / JSON, Proposal, "proposal")
    for law in found.laws:
        if not law.effect.isidentifier():
            raise UserError(f"{folder / JSON}: not a usable proposal: {law.effect!r} is no name of an effect")
    code = ""
    if found.laws:
        path = folder / f"{found.laws[0].effect}.py"
        if not path.is_file():
            return None  # it was stopped while it wrote
        code = read_text(path, "proposed effect", LARGEST_EFFECT_BYTES)
    return Kept(found, folder, code, _is_fresh(studio, c, found))


def _is_fresh(studio: Studio, c: str, found: Proposal) -> bool:
    """Whether a proposal was made of the model as it is now, and its laws are not in yet."""
    mine = about_model(models.model_path(studio, c))
    steps = mine.get("history") or ()
    if not steps or len(found.history) < len(steps):
        return False
    begun = found.history[len(steps) - 1].model_dump(mode="json", exclude_unset=True)
    taken = {one["effect"] for one in steps[-1]["model"]["effects"]} & {law.effect for law in found.laws}
    return not taken and models.is_last(mine, begun)


def free_law_name(studio: Studio, c: str) -> str:
    """A name for a law of a campaign that no effect has: ``sleeve_law``, ``sleeve_law_2``."""
    stem = re.sub(r"[^a-z0-9]+", "_", c.lower()).strip("_")[:40]
    stem = f"{stem}_law" if re.match("[a-z]", stem) else f"law_{stem}".rstrip("_")
    taken = studio.effects.catalogue().effects
    name, number = stem, 1
    while name in taken:
        number += 1
        name = f"{stem}_{number}"
    return name


def propose_command(studio: Studio, c: str, name: str, most: int) -> tuple[str, list[str]]:
    """Look for at most `most` laws beside the model of a campaign; what was proposed before makes room.

    Raises
    ------
    UserError
        If `name` is no name for an effect, or is taken.
    """
    from testbench.proposing.laws_found import check_names

    check_names(name, f"{name or 'name'}.py", studio.effects.catalogue().effects, most)
    folder = folder_of(studio, c)
    shutil.rmtree(folder, ignore_errors=True)
    make_folder(folder)
    argv = ["testbench", "propose", str(studio.workspace.campaign(c).folder)]
    argv += [*models.same_arguments(studio, c), "--laws", str(most)]
    argv += ["--json", str(folder / JSON), "--save-model", str(folder / MODEL), "-o", str(folder / f"{name}.py")]
    return f"Looking for a law that {c} lacks", argv


def take(studio: Studio, c: str, kept: Kept) -> None:
    """Put a proposed law to use: its class among the own effects, its refitted model on the ladder.

    The click that leads here is the user's consent to run the code that the page shows, and no other.

    Raises
    ------
    UserError
        If a question about the model is open, the model or the file has changed since it was shown, or own effects
        are there that nobody agreed to run.
    """
    models.refuse_while_asked(studio, c)
    now = kept_proposal(studio, c)
    if now is None or not now.fresh or now.code != kept.code:
        raise UserError("the model or the proposal has changed since; look for a law again")
    path, before = studio.effects.path, None
    if studio.effects.file is not None:
        if studio.effects.runnable is None:
            raise UserError(f"{path.name} holds effects that you have not agreed to run; look at them first")
        before = studio.effects.text()
    write_text(path, with_law(before or "", kept))
    studio.effects.agree()
    try:
        _adopt(studio, c, kept)
    except UserError:
        path.unlink() if before is None else write_text(path, before)
        studio.effects.agree()
        raise


def with_law(before: str, kept: Kept) -> str:
    """The text of a file of own effects with the law at its end; unchanged where the law is in it already.

    Raises
    ------
    UserError
        If another effect in it has the law's name.
    """
    if kept.code in before:
        return before
    for law in kept.found.laws:
        if re.search(rf"""^    name = ["']{re.escape(law.effect)}["']""", before, re.MULTILINE):
            raise UserError(f"there is another effect called {law.effect} already; look again under another name")
    return f"{before.rstrip()}\n\n\n{kept.code}" if before.strip() else kept.code


def _adopt(studio: Studio, c: str, kept: Kept) -> None:
    found = load_model_file(kept.folder / MODEL, studio.effects.catalogue())
    before = models.history_of(studio, c)
    diagnosis = read_diagnosis(models.diagnosis_path(studio, c)) if models.is_fresh(studio, c) else None
    found.save(models.model_path(studio, c))
    code = shlex.quote(str(kept.folder / f"{kept.found.laws[0].effect}.py"))
    studio.keep_command(c, f"cat {code} >> {shlex.quote(str(studio.effects.path))}")
    studio.keep_command(c, shlex.join(["cp", str(kept.folder / MODEL), str(models.model_path(studio, c))]))
    if diagnosis is not None:
        models.keep_diagnosis(studio, c, diagnosis, before, found.history[len(before)]["step"])
