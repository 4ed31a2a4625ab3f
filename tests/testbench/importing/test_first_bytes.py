"""The first bytes say what a file is, whatever the ending of its name: it is read, or refused with what it is."""

from __future__ import annotations

import gzip
import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.importing.sheet import Hints
from testbench.importing.wish import Wish
from tests.fuzz.targets import no_hang
from tests.testbench.importing import exports
from tests.testbench.importing.exports import EXTENSION_MM, FORCE_N, RESISTANCE_OHM, TIME_S, check_same, import_csv

NAMES = ("time_s", "extension_mm", "force_N", "resistance_ohm")
ROWS = np.column_stack([TIME_S, EXTENSION_MM, FORCE_N, RESISTANCE_OHM]).tolist()
RECORDS = [dict(zip(NAMES, row, strict=True)) for row in ROWS]
COLUMNS = {name: [one[name] for one in RECORDS] for name in NAMES}
PLAIN = ",".join(NAMES) + "\n" + "".join(",".join(map(repr, one.values())) + "\n" for one in RECORDS)


def page() -> str:
    rows = "".join("<tr>" + "".join(f"<td>{value}</td>" for value in one.values()) + "</tr>\n" for one in RECORDS)
    head = "".join(f"<th>{name.replace('_', ' [')}]</th>" for name in NAMES)
    return (
        "<!DOCTYPE html><html><table><tr><td>Sample</td><td>knit&nbsp;3</td></tr></table>"
        f'<table border="1"><tr><th colspan="4">Test &amp; co</th></tr><tr>{head}</tr>{rows}</table></html>'
    )


def nested() -> str:
    return "".join(
        json.dumps({"time_s": one["time_s"], "data": {name: one[name] for name in reversed(NAMES[1:])}}) + "\n"
        for one in RECORDS
    )


def parquet() -> bytes:
    pa = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    stream = io.BytesIO()
    parquet.write_table(pa.table(COLUMNS), stream)
    return stream.getvalue()


READ: dict[str, Callable[[Path], bytes]] = {
    "book.csv": lambda folder: exports.workbook(folder).read_bytes(),
    "book.xls": lambda folder: exports.workbook(folder).read_bytes(),
    "book": lambda folder: exports.workbook(folder).read_bytes(),
    "waves.txt": lambda folder: exports.labview(folder).read_bytes(),
    "text.xlsx": lambda folder: PLAIN.encode(),
    "text.xls": lambda folder: PLAIN.replace(",", "\t").encode("utf-16"),
    "text.tdms": lambda folder: PLAIN.encode("utf-16-le"),
    "page.xls": lambda folder: page().encode(),
    "page.csv": lambda folder: b"\xef\xbb\xbf\n" + page().encode(),
    "records.json": lambda folder: json.dumps(RECORDS).encode(),
    "spread.json": lambda folder: json.dumps({"setup": {"rate": 10}, "data": RECORDS}, indent=1).encode(),
    "columns.json": lambda folder: json.dumps({"rate": 10, **COLUMNS}).encode(),
    "pandas.json": lambda folder: json.dumps({n: dict(enumerate(c)) for n, c in COLUMNS.items()}).encode(),
    "split.json": lambda folder: json.dumps(
        {"columns": NAMES, "data": [list(one.values()) for one in RECORDS]}
    ).encode(),
    "lines.jsonl": lambda folder: nested().encode(),
    "lines.log": lambda folder: nested().encode("utf-16"),
    "table.parquet": lambda folder: parquet(),
    "table.csv": lambda folder: parquet(),
}


@pytest.mark.parametrize("name", READ)
def test_what_can_be_read_is_read(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(READ[name](tmp_path))
    check_same(import_csv(path, Wish(40.0)).recording) if name != "waves.txt" else None
    if name == "waves.txt":
        assert np.ptp(import_csv(path, Wish(40.0)).recording["force_N"]) == pytest.approx(np.ptp(FORCE_N), rel=1e-3)


def zipped(name: str) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr(name, PLAIN)
    return stream.getvalue()


REFUSED = {
    "an OpenDocument; open it": zipped("content.xml"),
    "a zip archive; unpack it": zipped("lab.csv"),
    "packed by gzip; unpack it": gzip.compress(PLAIN.encode()),
    "the old Excel format": bytes.fromhex("d0cf11e0a1b11ae1") + bytes(600),
    "a PDF document": b"%PDF-1.4\n1 0 obj\n2 0 obj\n",
    "an SQLite database": b"SQLite format 3\0" + bytes(100),
    "a MATLAB file": b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\1IM",
    "an HDF5 file": b"\x89HDF\r\n\x1a\n" + bytes(100),
    "an Excel table in XML": b'<?xml version="1.0"?><Workbook xmlns="urn:schemas-microsoft-com:office:spreadsheet"/>',
}


@pytest.mark.parametrize("what", REFUSED)
@pytest.mark.parametrize("name", ["lab.csv", "lab.xls", "lab"])
def test_what_cannot_is_called_by_its_name(tmp_path, what, name):
    path = tmp_path / name
    path.write_bytes(REFUSED[what])
    with pytest.raises(UserError, match=f"not a table but {what}"):
        import_csv(path, Wish(40.0))


def test_a_line_that_is_no_record_is_named_by_its_row_or_left_out(tmp_path):
    path = tmp_path / "cut.jsonl"
    lines = nested().splitlines()
    lines[20] = lines[20][:30]
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(UserError, match=r"row 21: time_s must be a number, got '\{\"time_s\": 2.0, "):
        import_csv(path, Wish(40.0))
    assert import_csv(path, Wish(40.0, drop_bad=True)).dropped == 1


def test_of_several_tables_one_is_chosen(tmp_path):
    path = tmp_path / "two.json"
    path.write_text(json.dumps({"runs": {"a": RECORDS, "b": RECORDS[:9]}}))
    with pytest.raises(UserError, match=r"the sheets 'runs.a', 'runs.b' have tables; say which"):
        import_csv(path, Wish(40.0))
    assert len(import_csv(path, Wish(40.0, hints=Hints(sheet="runs.b"))).recording) == 9


HOSTILE = {
    "open tags": "<table>" + "<td" * 300_000,
    "one long tag": "<table><" + "a" * 300_000,
    "wide cells": "<html><table><tr>" + "<td colspan=999>" * 30_000,
    "tables in tables": "<html>" + "<table><tr><td>" * 50_000,
    "deep lists": "[" * 300_000,
    "deep names": '{"a":' * 100_000,
    "a number of 5000 digits": ('{"a": 1' + "0" * 5000 + "}\n") * 9,
    "other names in every line": "".join(f'{{"t": {n}, "a{n}": 1}}\n' for n in range(5000)),
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_nobody_waits_for_a_hostile_one(tmp_path, text):
    path = tmp_path / "hostile.txt"
    path.write_text(text)
    with no_hang(), pytest.raises(UserError):
        import_csv(path, Wish(40.0))
