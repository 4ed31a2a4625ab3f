"""What made a campaign: versions of the software, and a fingerprint of the code that a simulation runs through."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib.metadata import version
from pathlib import Path

import gcode
import testbench
from gcode.support.console import knitbench_version

# A simulated byte may depend on the planner and on everything between the knit and the file, on no screen or fit.
_ROOMS = ("knit", "rig", ".")


def software_versions() -> dict[str, str]:
    """Versions that a simulation's last digit may depend on; ``code`` changes with every edit of that code."""
    return dict(_software_versions())


@cache
def _software_versions() -> dict[str, str]:
    # Looked up once: it reads the metadata of every installed distribution, and the source files.
    return {
        "knitbench": knitbench_version(),
        "code": code_fingerprint(),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "scipy": version("scipy"),
        "numba": version("numba"),
    }


def code_fingerprint() -> str:
    """First twelve hex digits of the SHA-256 of the source that simulates, names and bytes."""
    bench, planner = Path(testbench.__file__).parent, Path(gcode.__file__).parent
    files = [planner, *(bench / room for room in _ROOMS)]
    digest = hashlib.sha256()
    for path in sorted(path for folder in files for path in folder.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:12]


def changes_since(then: dict[str, str]) -> list[str]:
    """How this software differs from the one that wrote `then`: ``numpy 2.4.0, now 2.5.0``."""
    now = software_versions()
    return [
        f"{name} {then.get(name, 'not recorded')}, now {now[name]}" for name in now if then.get(name) != now[name]
    ]
