"""Files that are whole or not there, and what is said where they cannot be."""

from __future__ import annotations

import os

import pytest

from gcode.support.errors import UserError
from gcode.support.files import drafted_folder, existing_file


def test_a_pipe_is_called_one(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(UserError, match="a pipe or a device; save what comes from it in a file"):
        existing_file(tmp_path / "pipe")


def _raced(folder):
    with drafted_folder(folder):
        folder.mkdir()
        (folder / "theirs").touch()


def test_of_two_that_write_one_folder_the_second_is_told_so(tmp_path):
    with pytest.raises(UserError, match="race: another program has just written there"):
        _raced(tmp_path / "race")
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["race", "theirs"]
