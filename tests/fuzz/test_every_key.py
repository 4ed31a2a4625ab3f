"""Each of our own documents with every key changed in every way, read by its loader and the commands that read it.

No traceback, no hang, exit code 2 with a sentence; or an answer, where the change is one that is allowed. The quick
suite tries a few mutants of each document, the slow one all of them, and a share of those that load in every command.
"""

from __future__ import annotations

import json
import shutil
import warnings
from collections.abc import Mapping
from pathlib import Path

import pytest

from gcode.support.errors import UserError
from tests.fuzz.every_key import Mutant, chosen, fault_of, mutants
from tests.fuzz.kinds import KINDS, SLOWLY_MADE_BY, good_files, make
from tests.fuzz.targets import no_hang

QUICK = 8  # mutants of a document in the quick suite
FIRST, LATER = 60, 6  # in the slow one, of those that load: how many meet the first command, and each later one


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> Mapping[str, Path]:
    return good_files(tmp_path_factory.mktemp("every-key"))


@pytest.fixture(scope="module")
def all_files(files) -> Mapping[str, Path]:
    """The same without any sample."""
    make(SLOWLY_MADE_BY, files)
    return files


class Attacked:
    """One document, changed in place and read."""

    def __init__(self, files: Mapping[str, Path], name: str) -> None:
        self.kind = KINDS[name]
        self.place = files["out"].parent / self.kind.place
        self.text = self.place.read_text()
        self.paths = {**files, "doc": self.place.parent if self.kind.in_folder else self.place}
        self.faults: list[str] = []

    def load(self, mutant: Mutant) -> bool:
        """Whether the loader takes it."""
        self.place.write_text(mutant.text)
        try:
            with warnings.catch_warnings(), no_hang():
                warnings.simplefilter("ignore")
                self.kind.loader(self.place)
        except UserError:
            return False
        except Exception as error:
            self.faults.append(f"{mutant.change}: {type(error).__name__}: {str(error)[:200]}")
            return False
        return True

    def run(self, mutant: Mutant, command: str, allowed: tuple[int, ...] = (0, 1, 2)) -> None:
        """Give it to a command."""
        self.place.write_text(mutant.text)
        shutil.rmtree(self.paths["out"], ignore_errors=True)
        self.paths["out"].unlink(missing_ok=True)
        if fault := fault_of(command.format(**self.paths), allowed):
            self.faults.append(f"{mutant.change}: {command}: {fault}")

    def check_good(self, *commands: str) -> None:
        """A document that is refused unchanged would be refused changed, too, and nothing would have been tried."""
        unchanged = Mutant(self.text, "unchanged")
        assert self.load(unchanged)
        for command in commands:
            self.run(unchanged, command, allowed=(0,))
        assert "\n".join(self.faults) == ""

    def mutants(self, most: int = 1_000_000) -> list[Mutant]:
        return list(mutants(json.loads(self.text), self.kind.seal, most))


@pytest.fixture
def attacked(request, files):
    """The document of the name that is asked for; put back afterwards."""
    one = Attacked(files, request.param)
    yield one
    one.place.write_text(one.text)


@pytest.mark.parametrize("attacked", KINDS, indirect=True)
def test_a_changed_key_gets_a_sentence(attacked):
    attacked.check_good(*attacked.kind.commands[:1])
    for mutant in attacked.mutants(QUICK):
        attacked.load(mutant)
        for command in attacked.kind.commands[:1]:
            attacked.run(mutant, command)
    assert "\n".join(attacked.faults) == ""


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_every_changed_key_gets_a_sentence(all_files, name):
    attacked = Attacked(all_files, name)
    attacked.check_good(*attacked.kind.commands)
    found = attacked.mutants()
    loaded = [mutant for mutant in found if attacked.load(mutant)]
    print(f"\n{name}: {len(found)} mutants, of which {len(loaded)} are allowed")
    for number, command in enumerate(attacked.kind.commands):
        for mutant in chosen(loaded, LATER if number else FIRST, lambda one: one.change):
            attacked.run(mutant, command)
    attacked.place.write_text(attacked.text)
    assert "\n".join(attacked.faults) == ""
