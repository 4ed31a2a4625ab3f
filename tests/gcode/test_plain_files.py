"""What the one loader takes for a plain file: as many bytes as it says that it has, and none that is made up."""

from __future__ import annotations

import hashlib

import pytest

from gcode.support.errors import UserError
from gcode.support.files import sha256_of
from gcode.support.strict import check_plain, json_of, read_bytes

MADE_UP = "/proc/self/status"  # a regular file of size 0 that says something; /proc/kmsg is one that never ends


def test_no_more_is_read_than_a_file_says_that_it_has():
    assert read_bytes(MADE_UP) == b""
    assert sha256_of(MADE_UP) == hashlib.sha256().hexdigest()


def test_a_file_without_a_size_is_handed_to_no_other_reader():
    with pytest.raises(UserError, match="the file is empty"):
        check_plain(MADE_UP)


def test_a_file_that_a_kill_left_empty_may_be_taken_up(tmp_path):
    (tmp_path / "recording.bad").touch()
    assert check_plain(tmp_path / "recording.bad", may_be_empty=True) == 0


def test_a_file_is_read_to_its_end_and_no_larger_one(tmp_path):
    path, data = tmp_path / "file", bytes(range(256)) * 10_000
    path.write_bytes(data)
    assert read_bytes(path, at_most=len(data)) == data
    assert sha256_of(path) == hashlib.sha256(data).hexdigest()
    with pytest.raises(UserError, match="larger than"):
        read_bytes(path, at_most=len(data) - 1)


@pytest.mark.parametrize(
    "text", ['"\\u001b[31m"', '["\\u0000"]', '{"a": {"\\u009b": 1}}', '{"a": "\\ud800"}', '"\\u007f"']
)
def test_text_that_steers_a_terminal_or_is_no_text_is_refused(text):
    with pytest.raises(UserError, match="a control character, or half of a character"):
        json_of(text)


def test_what_people_write_is_text():
    assert json_of('"a line\\nand another\\tΩ \\ud83d\\ude00"') == "a line\nand another\tΩ \U0001f600"
