"""Workbooks, TDMS files and archives that unpack to more than any memory, or say so: a sentence, no more."""

from __future__ import annotations

import resource
import struct
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.cli import main
from testbench.importing.files import unpacking
from testbench.importing.files.unpacking import check_unpacked
from testbench.importing.vocabulary.headings import read_heading
from testbench.importing.wish import Wish
from tests.fuzz.targets import no_hang
from tests.testbench.importing import exports
from tests.testbench.importing.exports import import_csv

SHEET, STRINGS = "xl/worksheets/sheet1.xml", "xl/sharedStrings.xml"
BLANK = b" " * (1 << 20)
OPEN = b'<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><sheetData>'
CLOSE = b"</sheetData></worksheet>"


@pytest.fixture
def small(monkeypatch):
    """The bounds, small: what is tested is that they are kept, not how long it takes to reach them."""
    changes = {"MOST_SHEET_BYTES": 2 << 20, "MOST_OTHER_BYTES": 4 << 20, "MOST_ROWS": 100_000}
    for name, value in {**changes, "MOST_CELLS": 2_000_000, "MOST_ELEMENTS": 100_000}.items():
        monkeypatch.setattr(unpacking, name, value)


@pytest.fixture(autouse=True)
def room_for_two_gigabytes() -> Iterator[None]:
    """What needs more than this above what is there already fails."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + (2 << 30), before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def workbook(folder: Path, part: str, blocks: list[bytes]) -> Path:
    """A good workbook, in which one part is replaced by these bytes, packed."""
    good, path = exports.workbook(folder), folder / "hostile.xlsx"
    with zipfile.ZipFile(good) as source, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as target:
        for info in source.infolist():
            if info.filename != part:
                target.writestr(info, source.read(info))
        with target.open(part, "w") as stream:
            for block in blocks:
                stream.write(block)
    assert path.stat().st_size < 4 << 20
    return path


def sheet(*rows: bytes) -> list[bytes]:
    return [OPEN, *rows, CLOSE]


HOSTILE = {
    "a sheet of blanks": (SHEET, sheet(*[BLANK] * 4), "more than 2 MB;"),
    "texts of blanks": (STRINGS, [b"<sst>", *[BLANK] * 6], "more than 4 MB, sheets not counted"),
    "millions of texts": (STRINGS, [b"<sst>", b"<si/>" * 200_000, b"</sst>"], "elements outside rows"),
    "one endless row": (SHEET, sheet(b"<row>", b"<c/>" * 200_000, b"</row>"), "a row of more than"),
    "rows within a row": (SHEET, sheet(b"<row>", b"<row/>" * 200_000, b"</row>"), "a row of more than"),
    "millions of rows": (SHEET, sheet(b"<row/>" * 200_000), "more than 100000 rows"),
    "a row far below": (SHEET, sheet(b'<row r="99999999999999"><c><v>1</v></c></row>'), "more than 100000 rows"),
    "cells far to the right": (SHEET, sheet(b'<row><c r="XFD1"><v>1</v></c></row>' * 200), "more than 2000000 cells"),
    "no end of it": (SHEET, [OPEN, b"<row>"], "not an Excel workbook that can be read"),
    "a formula's text": (SHEET, sheet(b'<row r="1"><c t="s"><v>99</v></c></row>'), "broken parts"),
}


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.usefixtures("small")
def test_a_workbook_that_unpacks_to_too_much_is_refused(tmp_path, name):
    part, blocks, said = HOSTILE[name]
    path = workbook(tmp_path, part, blocks)
    with pytest.raises(UserError, match=said) as error, no_hang():
        import_csv(path, Wish(40.0))
    assert "hostile.xlsx" in str(error.value)


def test_what_a_sheet_says_of_its_size_is_not_believed(tmp_path):
    rows = b"".join(b"<row><c><v>%d</v></c><c><v>%d</v></c></row>" % (n, n % 7) for n in range(300))
    blocks = [OPEN.replace(b"<sheetData>", b'<dimension ref="A1:XFD1048576"/><sheetData>'), rows, CLOSE]
    with pytest.raises(UserError, match="say which"):
        import_csv(workbook(tmp_path, SHEET, blocks), Wish(40.0))


def test_an_entity_that_grows_is_refused(tmp_path):
    levels = b"".join(b'<!ENTITY l%d "%s">' % (n + 1, b"&l%d;" % n * 10) for n in range(9))
    bomb = b'<!DOCTYPE x [<!ENTITY l0 "lollollollol">' + levels + b"]><sst><si><t>&l9;</t></si></sst>"
    with pytest.raises(UserError, match="not an Excel workbook"):
        import_csv(workbook(tmp_path, STRINGS, [bomb]), Wish(40.0))


def test_a_good_workbook_passes(tmp_path):
    check_unpacked(exports.workbook(tmp_path))


def test_a_tdms_file_that_says_more_than_it_holds_is_refused(tmp_path):
    """Every count and size of its head in turn, made huge."""
    good = exports.labview(tmp_path).read_bytes()
    said = []
    for place in range(0, 600, 40):
        for huge in (struct.pack("<I", 0x7FFFFFFF), struct.pack("<Q", 1 << 62)):
            path = tmp_path / "hostile.tdms"
            path.write_bytes(good[:place] + huge + good[place + len(huge) :])
            said += refusal(path)
    assert len(said) > 5
    assert all("hostile.tdms" in text for text in said)


def refusal(path: Path) -> list[str]:
    try:
        import_csv(path, Wish(40.0))
    except UserError as error:
        return [str(error)]
    return []


@pytest.mark.parametrize("name", ["arrays.npz", "arrays.npy", "table.csv.gz"])
def test_an_archive_of_numbers_is_no_table(tmp_path, capsys, name):
    with (tmp_path / name).open("wb") as stream:
        np.savez_compressed(stream, time_s=np.zeros(50_000_000, dtype=np.int8))
    code = main(["import", str(tmp_path / name), "--gauge-length-mm", "25", "-o", str(tmp_path / "out")])
    assert code == 2
    assert name in capsys.readouterr().err


@pytest.mark.parametrize("part", ["aB_1", "dR_1", "kN 1 ", "mA1_1", "Time_s_1_"])
def test_a_name_of_many_ends_is_read_in_no_time(part):
    """Each end may be a unit; the ways through forty letters of them took minutes."""
    with no_hang():
        assert read_heading(part * 75).text
