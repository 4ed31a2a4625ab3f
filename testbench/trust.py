"""The trust boundary for code: data never run code, a program runs only because a person named it or clicked.

An effects file is a Python program with the rights of whoever loads it. Recordings, models, specs and folders come
from strangers, so what they say is never enough: either the person names the file on the command line
(`named_effects`), or has said yes to these very bytes before (`trust`, `is_trusted`; the studio asks before it loads
what lies in a folder). See SECURITY.md.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.files import make_folder, sha256_of, write_text

EFFECTS_HELP = "Python file with effects of your own: a program that runs as you, so read a stranger's first"
STORE = Path("knitbench") / "trusted-effects.txt"
_MOST_BYTES = 1 << 20


def named_effects(source: str | Path, wanted: Path, named: Path | None, sha256: str | None = None) -> Path:
    """The effects file that `source` asks for, if the person has named it.

    Parameters
    ----------
    source : str or Path
        The data that want it: a campaign folder, a data set's spec.
    wanted : Path
        Where they say that it is.
    named : Path or None
        What stands after ``--effects``.
    sha256 : str, optional
        Which bytes it must have; default: those of `wanted`.

    Raises
    ------
    UserError
        If nothing was named, or another file than `source` asks for.
    """
    if named is None:
        raise UserError(
            f"{source}: needs effects of somebody's own; read {wanted}, which is a program, and if you trust it, "
            f"give `effects` {wanted}"
        )
    if sha256 is None:
        sha256 = sha256_of(wanted) if wanted.is_file() else ""
    if not named.is_file() or sha256_of(named) != sha256:
        raise UserError(f"{named}: not the effects that {source} needs; those are in {wanted}")
    return named


def is_trusted(path: str | Path) -> bool:
    """Whether this user has said yes, once and on this machine, to the bytes that are in this file now."""
    try:
        return Path(path).is_file() and sha256_of(path) in _remembered()
    except UserError:
        return False


def trust(path: str | Path) -> None:
    """Remember that the user says yes to the bytes that are in this file now; a change asks again.

    It is kept with the user (``$XDG_STATE_HOME``, else ``~/.local/state``), never in a folder of data: that folder
    may be the stranger's.
    """
    digests = _remembered() | {sha256_of(path)}
    make_folder(_store().parent)
    write_text(_store(), "".join(f"{digest}\n" for digest in sorted(digests)))


def _store() -> Path:
    base = os.environ.get("XDG_STATE_HOME", "")
    return (Path(base) if os.path.isabs(base) else Path.home() / ".local" / "state") / STORE


def _remembered() -> set[str]:
    from gcode.support.strict import read_text  # pydantic is slow to import, and every --help comes by here

    try:
        text = read_text(_store(), "list of trusted effects", _MOST_BYTES)
    except UserError:
        return set()
    return set(re.findall(r"^[0-9a-f]{64}$", text, re.MULTILINE))
