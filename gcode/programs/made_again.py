"""Where a program comes from: ours are made again from the recipe in their header and compared, line by line."""

from __future__ import annotations

from dataclasses import dataclass, replace

from gcode.mach4.check import CheckResult, check_program
from gcode.mach4.controller import Machine
from gcode.mach4.header import seal_problem
from gcode.mach4.program import Problem, Program
from gcode.mach4.reader import parse_program
from gcode.support.console import knitbench_version
from gcode.support.errors import UserError
from gcode.trajectories.bounds import Limits

FOREIGN = "nobody's recipe: judged by its motion alone"
GENUINE = "made again from its recipe, line by line the same"


@dataclass(frozen=True)
class Provenance:
    """What is known of a program's origin.

    Attributes
    ----------
    words : str
        For the person who checks.
    genuine : bool
        Whether the recipe in its header gives this very program.
    problems : tuple of Problem
        What speaks against running it.
    """

    words: str
    genuine: bool = False
    problems: tuple[Problem, ...] = ()


def check_file(
    text: str,
    limits: Limits,
    rate_hz: float = 20.0,
    machine: Machine | None = None,
    *,
    rapid_mm_per_s: float | None = None,
    longest_dwell_s: float | None = None,
    as_foreign: bool = False,
) -> tuple[CheckResult, Provenance]:
    """Check the text of a program: where it comes from, and what is found in it; see `gcode.check`."""
    program = parse_program(text)
    origin = Provenance(FOREIGN) if as_foreign else provenance(text, program)
    if longest_dwell_s is None and origin.genuine:
        longest_dwell_s = float("inf")
    result = check_program(
        program, limits, rate_hz, machine, rapid_mm_per_s=rapid_mm_per_s, longest_dwell_s=longest_dwell_s
    )
    problems = sorted([*result.problems, *origin.problems], key=lambda problem: problem.line)
    return replace(result, problems=tuple(problems)), origin


def provenance(text: str, program: Program) -> Provenance:
    """Hold a program against its seal and its recipe; one without a header of ours is nobody's."""
    from gcode.programs.make import make_again

    keys = program.header
    if not any(key.startswith("spec.") for key in keys):
        # A header that states a rate but no recipe proves nothing: the file is judged as anybody's, but for its seal.
        broken = seal_problem(text) if "sha256" in keys else ""
        return _refused(1, f"{broken}; {REMEDY}") if broken else Provenance(FOREIGN)
    if program.problems:
        return Provenance("its recipe was not tried")
    broken = seal_problem(text)
    try:
        again = make_again(program).program
    except (UserError, ValueError, ArithmeticError) as error:
        return _refused(1, f"the recipe in its header cannot be made again ({error}); {REMEDY}")
    lines, wanted = text.replace("\r\n", "\n").split("\n"), again.split("\n")
    if lines == wanted:
        return Provenance(GENUINE, genuine=True)
    if broken and _unsealed(lines) == _unsealed(wanted):
        return Provenance(f"{GENUINE}, but without a seal", genuine=True)
    return _different(lines, wanted, broken, keys.get("version", ""))


REMEDY = "make it again with `gcode generate`, or judge it as anybody's with `as_foreign`"


def _different(lines: list[str], wanted: list[str], broken: str, version: str) -> Provenance:
    number = next(
        (n for n, (came, due) in enumerate(zip(lines, wanted, strict=False)) if came != due),
        min(len(lines), len(wanted)),
    )
    came = lines[number][:60] if number < len(lines) else "nothing"
    due = wanted[number][:60] if number < len(wanted) else "nothing"
    other = f", made by version {version}" if version and version != knitbench_version() else ""
    reason = f"is not what the recipe in its header gives{other}: {due!r} is due, {came!r} came; {REMEDY}"
    return _refused(number + 1, f"{broken}; {reason}" if broken else reason)


def _refused(line: int, reason: str) -> Provenance:
    return Provenance("not the program that its header promises", problems=(Problem(line, reason),))


def _unsealed(lines: list[str]) -> list[str]:
    return [line for line in lines if not line.startswith("(SHA256: ")]
