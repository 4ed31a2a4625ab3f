"""Options that the benchmarks of compensators share."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

SIMULATED, MEASURED = ("pes", "lycra"), ("measured", "others", "further", "unseen")


def add_campaigns(parser: argparse.ArgumentParser) -> None:
    """Where simulated campaigns are kept, and found again."""
    place = Path(tempfile.gettempdir()) / "knitbench-bench"
    parser.add_argument("--campaigns", type=folder, default=str(place), help="kept here and used again")


def add_specimens(parser: argparse.ArgumentParser, flag: str, default: str | None, what: str) -> None:
    """Numbers of simulated specimens."""
    parser.add_argument(flag, type=numbers, default=default, metavar="N,N,..", help=what)


def add_kinds(parser: argparse.ArgumentParser, default: Sequence[str], allowed: Sequence[str]) -> None:
    """Kinds of `compensator_cases`."""
    parser.add_argument(
        "--kinds",
        type=names(allowed),
        default=tuple(default),
        metavar="KIND,..",
        help=f"only these, of {', '.join(allowed)}",
    )


def folder(text: str) -> Path:
    """A folder, made where it is not there."""
    place = Path(text)
    place.mkdir(parents=True, exist_ok=True)
    return place


def numbers(text: str) -> tuple[int, ...]:
    """The whole numbers of ``871,872``."""
    try:
        return tuple(int(number) for number in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"must be whole numbers with commas, such as 871,872; got {text!r}"
        ) from None


def names(allowed: Sequence[str]) -> Callable[[str], tuple[str, ...]]:
    """Reads some of the allowed names, with commas between them."""

    def some(text: str) -> tuple[str, ...]:
        found = tuple(text.split(","))
        if not set(found) <= set(allowed):
            raise argparse.ArgumentTypeError(f"must be of {', '.join(allowed)}, with commas; got {text!r}")
        return found

    return some
