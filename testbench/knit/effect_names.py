"""Names of effects, and of the classes that are written for them."""

from __future__ import annotations

import keyword
from collections.abc import Collection

from gcode.support.errors import UserError

HYPOTHESES = ("nothing", "unknown")  # what a diagnosis weighs beside the effects; no effect may be called so
IMPORTED = ("Effect", "Stage")  # what a file of an effect imports; no class of its own may be called so


def class_name(name: str) -> str:
    """Name of the class of an effect: ``my_effect`` -> ``MyEffect``."""
    return "".join(part.capitalize() for part in name.split("_"))


def check_name(name: str, source: str, taken: Collection[str]) -> None:
    """Refuse what is no name for an effect that a file is written for.

    Raises
    ------
    UserError
        With `source` in front.
    """
    cls = class_name(name)
    words = (name, cls)
    if any(not word.isidentifier() or keyword.iskeyword(word) for word in words) or name != name.lower():
        raise UserError(
            f"{source}: an effect is named after its file, which must be like my_effect.py (lower case, digits, _); "
            f"got {name!r}"
        )
    if cls in IMPORTED:
        raise UserError(f"{source}: a file of an effect imports {cls}, so its own class needs another name")
    check_free(name, source, taken)


def check_free(name: str, source: str, taken: Collection[str]) -> None:
    """Refuse what is no word, the name of another effect, or of what a diagnosis weighs beside effects.

    Raises
    ------
    UserError
        With `source` in front.
    """
    if not (isinstance(name, str) and name.isidentifier()):
        raise UserError(f"{source}: an effect's name is one word of letters, digits and _; got {name!r}")
    if name in HYPOTHESES:
        raise UserError(f"{source}: a diagnosis has a hypothesis called {name}; give the effect another name")
    if name in taken:
        raise UserError(f"{source}: there is an effect called {name} already; give yours another name")
