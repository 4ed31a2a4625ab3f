"""Every kind of file and folder that is not what a command asked for; `attack_commands` puts each in every place."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

WHOLE = {
    "empty": b"",
    "zeros": bytes(5000),
    "random": bytes(range(256)) * 20,
    "not utf-8": b"\xff\xfe\xfa" * 100,
    "deep json": b"[" * 100_000,
    "deep toml": b"a = " + b"[" * 5000,
    "huge number": b'{"format": "knitbench-model", "version": 1, "effects": [], "gauge_length_mm": 1e999}',
    "many digits": b'{"version": ' + b"9" * 5000 + b"}",
    "a list": b"[]",
    "a null": b"null",
    "one line of 1 MB": b"1," * 500_000,
    "header alone": b"time_s,displacement_mm,force_N\n",
    "nan": b"time_s,displacement_mm,force_N,resistance_ohm\nnan,nan,nan,nan\n0,inf,1,1\n1,1e308,1e308,0\n",
    "time runs back": b"time_s,displacement_mm,force_N,resistance_ohm\n1,1,1,1\n0,1,1,1\n-1,1,1,1\n",
    "zip that is none": b"PK\x03\x04" + bytes(300),
    "tdms that is none": b"TDSm" + b"\xff" * 300,
    "old excel": bytes.fromhex("d0cf11e0a1b11ae1") + bytes(600),
    "escape codes": b"\x1b]0;owned\x07\x1b[2J,\n1,2\n",
}


def wrong_files(folder: Path, good: dict[str, Path]) -> dict[str, Path]:
    """Make them in `folder`, some of them out of the `good` ones; each by a name that says what is wrong."""
    folder.mkdir()
    found = _contents(folder)
    found |= _copies(folder, good)
    found |= _too_large(folder)
    found |= _places(folder)
    devices = {name: Path(name) for name in ("/dev/zero", "/dev/full", "/dev/null", "/proc/self/mem", "/")}
    return found | _folders(folder, good) | devices


def _contents(folder: Path) -> dict[str, Path]:
    """Bytes that are nothing, or only look like something."""
    found = {}
    for name, data in WHOLE.items():
        for end in ("csv", "json", "xlsx", "tdms") if "none" in name else ("x",):
            found[f"{name}.{end}"] = folder / f"{name}.{end}"
            found[f"{name}.{end}"].write_bytes(data)
    return found


def _copies(folder: Path, good: dict[str, Path]) -> dict[str, Path]:
    """Good files in the wrong place, cut in half, with an odd name, or with rights that forbid."""
    found = {}
    for name, path in good.items():
        if path.is_file():
            found[f"a {name}"] = path
            cut = folder / f"half a {path.name}"
            cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
            found[cut.name] = cut
    for name, source in {
        "编织 é.csv": "recording",
        "a file that must stay.json": "model",
        "unreadable.csv": "recording",
    }.items():
        found[name] = shutil.copy(good[source], folder / name)
    found["name that is no text"] = shutil.copy(good["recording"], folder / os.fsdecode(b"\xff.csv"))
    (folder / "a file that must stay.json").chmod(0o444)
    (folder / "unreadable.csv").chmod(0)
    return found


def _too_large(folder: Path) -> dict[str, Path]:
    """Files of 5 GB that take no room."""
    found = {f"5 GB.{end}": folder / f"5 GB.{end}" for end in ("csv", "json", "tap", "xlsx")}
    for path in found.values():
        with path.open("wb") as huge:
            huge.truncate(5 << 30)
    return found


def _places(folder: Path) -> dict[str, Path]:
    """Folders that forbid, pipes, links in a circle or to nowhere, names that no terminal should see."""
    found = {}
    for name, mode in {"locked": 0, "read only": 0o555}.items():
        (folder / name).mkdir()
        found[f"a {name} folder"], found[f"below a {name} folder"] = folder / name, folder / name / "out"
        (folder / name).chmod(mode)
    os.mkfifo(folder / "pipe")
    (folder / "loop").symlink_to(folder / "loop")
    (folder / "to nowhere").symlink_to(folder / "nowhere")
    (folder / "a folder").mkdir()
    (folder / "a\nb\x1b[31m.csv").write_bytes(b"x")
    for name in ("pipe", "loop", "to nowhere", "a folder", "a\nb\x1b[31m.csv", "missing", "pipe/below", "n" * 300):
        found[name] = folder / name
    return found


def _folders(folder: Path, good: dict[str, Path]) -> dict[str, Path]:
    """Campaigns and investigations in which one file is wrong."""
    found = {}

    def changed(kind: str, name: str) -> Path:
        found[f"{kind}: {name}"] = folder / f"{kind} {name}"
        shutil.copytree(good[kind], folder / f"{kind} {name}")
        return folder / f"{kind} {name}"

    files = {
        "campaign": ("datapackage.json", "recording.csv", "program.tap", "events.jsonl"),
        "investigation": ("investigation.json", "sensor.json"),
    }
    for kind, file in ((kind, file) for kind, names in files.items() for file in names):
        (changed(kind, f"no {file}") / file).unlink()
        place = changed(kind, f"a pipe for {file}") / file
        place.unlink()
        os.mkfifo(place)
        place = changed(kind, f"a link loop for {file}") / file
        place.unlink()
        place.symlink_to(place)
        place = changed(kind, f"a folder for {file}") / file
        place.unlink()
        place.mkdir()
        place = changed(kind, f"half of {file}") / file
        place.write_bytes(place.read_bytes()[: place.stat().st_size // 2])
        place = changed(kind, f"one bit of {file}") / file
        data = bytearray(place.read_bytes())
        data[len(data) // 2] ^= 1
        place.write_bytes(data)
    return found
