"""Two hundred small changes to a program that may run: each is refused, or is no change when it is executed.

`gcode check` reads; the judge here is the replay (`gcode.mach4.controller.play`): a mutant that passes the check must
move as the original moves, to the resolution of the program's own numbers.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable

import numpy as np
import pytest

from gcode.mach4.controller import play
from gcode.mach4.reader import read_program
from gcode.programs.made_again import check_file
from gcode.support.errors import UserError
from gcode.trajectories.bounds import Limits
from tests.gcode.test_made_again import TEXT, resealed

LIMITS = Limits(v_max_mm_per_s=5, a_max_mm_per_s2=20, x_min_mm=-1, x_max_mm=10)
# What nobody made: no recipe in its header, so that only its execution can be judged.
FOREIGN = (
    "G90 G21 G94 G64\n" + "".join(f"G1 X{x:.3f} F{6 + n}\n" for n, x in enumerate((2, 1, 3, 0.5, 4, 0))) + "M30\n"
)
COUNT, RATE_HZ, RESOLUTION_MM = 100, 100.0, 1e-4


def code_lines(lines: list[str]) -> list[int]:
    return [number for number, line in enumerate(lines) if line and not line.startswith("(")]


def swapped(lines: list[str], rng: random.Random) -> None:
    places = code_lines(lines)
    one, other = rng.sample(places, 2)
    lines[one], lines[other] = lines[other], lines[one]


def deleted(lines: list[str], rng: random.Random) -> None:
    del lines[rng.choice(code_lines(lines))]


def doubled(lines: list[str], rng: random.Random) -> None:
    place = rng.choice(code_lines(lines))
    lines.insert(place, lines[place])


def another_digit(lines: list[str], rng: random.Random) -> None:
    place = rng.choice([number for number in code_lines(lines) if re.search(r"\d", lines[number])])
    at = rng.choice([match.start() for match in re.finditer(r"\d", lines[place])])
    digit = rng.choice([one for one in "0123456789" if one != lines[place][at]])
    lines[place] = lines[place][:at] + digit + lines[place][at + 1 :]


def another_character(lines: list[str], rng: random.Random) -> None:
    place = rng.choice(code_lines(lines))
    at = rng.randrange(len(lines[place]))
    lines[place] = lines[place][:at] + rng.choice("XYZFGMNP+-.;%/#[(\t ") + lines[place][at + 1 :]


def lost_character(lines: list[str], rng: random.Random) -> None:
    place = rng.choice(code_lines(lines))
    at = rng.randrange(len(lines[place]))
    lines[place] = lines[place][:at] + lines[place][at + 1 :]


def cut_short(lines: list[str], rng: random.Random) -> None:
    del lines[rng.choice(code_lines(lines)) :]


def a_word_more(lines: list[str], rng: random.Random) -> None:
    words = (
        "G91",
        "G20",
        "G0",
        "G2 R1",
        "G55",
        "G92 X1",
        "G93",
        "M0",
        "M98 P1",
        "Y5",
        "F1e9",
        "T1",
        "G10 L2 P1 X1",
        "S9",
    )
    lines.insert(rng.choice(code_lines(lines)), rng.choice(words))


def ended(lines: list[str], rng: random.Random) -> None:
    lines.insert(rng.choice(code_lines(lines)), "M30")


KINDS: tuple[Callable[[list[str], random.Random], None], ...] = (
    swapped,
    deleted,
    doubled,
    another_digit,
    another_character,
    lost_character,
    cut_short,
    a_word_more,
    ended,
)


def mutants(text: str, seal: Callable[[str], str]) -> list[tuple[str, str]]:
    """Name and text of each, the same ones on every machine; what came out unchanged is made again."""
    found: list[tuple[str, str]] = []
    seed = 0
    while len(found) < COUNT:
        rng, lines, kind = random.Random(seed), text.split("\n"), KINDS[seed % len(KINDS)]
        kind(lines, rng)
        seed += 1
        if "\n".join(lines) != text:
            found.append((f"{kind.__name__} {seed - 1}", seal("\n".join(lines))))
    return found


def executed(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Where the axis is, and when."""
    trajectory = play(read_program(text), rate_hz=RATE_HZ)
    return trajectory.time_s, trajectory.position_mm


def moves_alike(text: str, other: str) -> bool:
    (time_s, position_mm), (_, changed_mm) = executed(text), executed(other)
    return len(position_mm) == len(changed_mm) and bool(
        np.abs(position_mm - changed_mm).max() <= RESOLUTION_MM and time_s[-1] > 0
    )


def passes(text: str) -> bool:
    try:
        return check_file(text, LIMITS)[0].ok
    except UserError:
        return False


@pytest.mark.parametrize("seal", [lambda text: text, resealed], ids=["as it is", "sealed again"])
def test_a_mutant_of_our_own_is_refused_or_moves_alike(seal):
    """A forger seals it again; the recipe in its header is still not what it does."""
    assert passes(TEXT)
    through = [(name, text) for name, text in mutants(TEXT, seal) if passes(text)]
    assert [name for name, text in through if not moves_alike(TEXT, text)] == []
    assert len(through) < COUNT / 10


def test_a_mutant_of_a_strangers_is_refused_or_keeps_the_limits():
    """Nobody can know what a stranger meant: what passes must be executed to its end, within the limits."""
    assert passes(FOREIGN)
    through = [(name, text) for name, text in mutants(FOREIGN, lambda text: text) if passes(text)]
    for name, text in through:
        time_s, position_mm = executed(text)
        speed = np.abs(np.diff(position_mm)) / np.diff(time_s)
        assert position_mm.min() >= LIMITS.x_min_mm - RESOLUTION_MM, name
        assert position_mm.max() <= LIMITS.x_max_mm + RESOLUTION_MM, name
        assert speed.max() <= LIMITS.v_max_mm_per_s + 1e-6, name
    assert 0 < len(through) < COUNT
