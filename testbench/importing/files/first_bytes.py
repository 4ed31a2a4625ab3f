"""What a file is, as its first bytes say: the ending of its name may be that of another program."""

from __future__ import annotations

import zipfile
from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.strict import blocks_of
from testbench.importing.files.encodings import encoding_of

TEXT, WORKBOOK, TDMS, PARQUET, PAGE, JSON = "text", "workbook", "tdms", "parquet", "page", "json"
ENDINGS = {".xlsx": WORKBOOK, ".xlsm": WORKBOOK, ".tdms": TDMS, ".parquet": PARQUET}
_READ = {b"PK\3\4": WORKBOOK, b"TDSm": TDMS, b"PAR1": PARQUET}
# What begins so is not read: what it is, and what to do.
_SAVE_AS = "open it in Excel or LibreOffice and save it as .xlsx"
_OLD = f"the old Excel format, or a workbook with a password; {_SAVE_AS}"
_ELSE = {
    b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1": _OLD,
    b"\x09\x08": _OLD,
    b"\x1f\x8b": "packed by gzip; unpack it",
    b"BZh": "packed by bzip2; unpack it",
    b"\xfd7zXZ": "packed by xz; unpack it",
    b"7z\xbc\xaf": "a 7z archive; unpack it",
    b"Rar!": "a rar archive; unpack it",
    b"%PDF": "a PDF document; export the table itself as CSV",
    b"SQLite format 3": "an SQLite database; export the table as CSV",
    b"\x89HDF": "an HDF5 file (of MATLAB from v7.3 on, too); export the table as CSV",
    b"MATLAB 5.0": "a MATLAB file; write the table with writetable(..., 'lab.csv')",
    b"\x93NUMPY": "a NumPy array; write it with numpy.savetxt, names in its header",
    b"\x80\4\x95": "a Python pickle; write the table with to_csv",
    b"{\\rtf": "an RTF document; export the table itself as CSV",
    b"\x89PNG": "a picture; export the table itself as CSV",
    b"\xff\xd8\xff": "a picture; export the table itself as CSV",
}
_LOOK = 4096  # bytes in which a page has begun


def kind_of(path: Path) -> str:
    """`TEXT` or another kind that can be read: by the first bytes; where they are of none, by the ending of its name.

    Raises
    ------
    UserError
        If it is of a kind that is not read; the message says what it is.
    """
    raw, ending = next(blocks_of(path, "table"), b""), path.suffix.lower()
    if what := next((what for begin, what in _ELSE.items() if raw.startswith(begin)), ""):
        raise UserError(f"{path}: not a table but {what}")
    if kind := next((kind for begin, kind in _READ.items() if raw.startswith(begin)), ""):
        if kind == WORKBOOK and ENDINGS.get(ending) != WORKBOOK:
            _check_workbook(path)
        return kind
    encoding = encoding_of(raw[: raw.rfind(b"\n") + 1] or raw) or ""
    if ending not in (".xls", *ENDINGS) or encoding:
        return _kind_of_text(path, raw[:_LOOK].decode(encoding or "latin-1", errors="replace").lstrip().lower())
    if ending == ".xls":
        raise UserError(f"{path}: not a table but {_OLD}")
    return ENDINGS[ending]


def _kind_of_text(path: Path, begin: str) -> str:
    if begin.startswith(("{", "[")):
        return JSON
    if not begin.startswith("<"):
        return TEXT
    if "urn:schemas-microsoft-com:office:spreadsheet" in begin:
        raise UserError(f"{path}: not a table but an Excel table in XML; {_SAVE_AS}")
    return PAGE if "<html" in begin or "<table" in begin else TEXT


def _check_workbook(path: Path) -> None:
    """Refuse another zip than a workbook, by what is in it."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except (OSError, ValueError, RuntimeError, NotImplementedError, zipfile.BadZipFile):
        names = []
    if not any(name.startswith("xl/") for name in names):
        what = f"an OpenDocument; {_SAVE_AS}" if "content.xml" in names else "a zip archive; unpack it"
        raise UserError(f"{path}: not a table but {what}")
