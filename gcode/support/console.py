"""The frame of the three console commands: one file a sub-command, imported only when it is called.

A sub-command is a module with ``SUMMARY`` (one line), ``EXAMPLE`` (shown under ``--help``),
``add_arguments(parser)`` and ``run(args) -> int | None``. Heavy imports belong inside ``run``,
so that ``--help`` answers at once. A command never writes over a file that it reads, but where ``IN_PLACE`` says so:
``{"output": "model"}`` lets a new model take the place of the one it came from.

Messages come from the public functions, and name their parameters in backticks: ``give `held_out` ``. Here, and
nowhere else, such a name becomes the option of the command that runs: ``give --held-out``. So does the one that an
error begins with: ``seed must be 0 or more``, ``Limits: v_max_mm_per_s: ...``. It is the ``dest`` of the option.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import json
import os
import re
import stat
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any, NoReturn, TextIO, cast

from gcode.support import streams
from gcode.support.errors import UserError, first_problem

# The folder that a command is started in may be a stranger's. Python looks for modules there in each process that we
# start (workers, the studio's jobs); numba obeys a .numba_config.yaml there, and unpickles the cache that it names.
KEPT_OUT = {"PYTHONSAFEPATH": "1", "NUMBA_CACHE_DIR": "", "NUMBA_CACHE_LOCATOR_CLASSES": ""}
WRITTEN = frozenset({"output", "out", "json", "plot", "save_model"})  # arguments that name files to write
WORDS = frozenset({"title", "name", "specimen"})  # arguments that are no file, though one may have that name
MOST_PROCESSES = 1024
# Of the environment: libraries end in a traceback where these are no such numbers, some while they are imported.
NUMBERS = {"SOURCE_DATE_EPOCH": (0, 99_999_999_999), "NUMBA_NUM_THREADS": (1, MOST_PROCESSES)}
EXIT_BAD_INPUT = 2
_SUBJECT = re.compile(r"^(?:[A-Z]\w*: )?(?:(?:\w+\.)+(?=[a-z]+_))?([a-z]\w*)(?=:| must )")  # a name, no file's
_OPTIONS: dict[str, str] = {}  # of the command that runs, by the name of the parameter in small letters
EXIT_INTERRUPTED = 130


def knitbench_version() -> str:
    """Version of the installed distribution; ``0+unknown`` when run from a bare source tree."""
    try:
        return version("knitbench")
    except PackageNotFoundError:
        return "0+unknown"


class _Parser(argparse.ArgumentParser):
    """argparse with one-line errors that say what is allowed, and where help is."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.register("type", int, _number(int, "a whole number"))
        self.register("type", float, _number(float, "a number"))
        self._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$", re.IGNORECASE)  # -1e-3, too

    def error(self, message: str) -> NoReturn:
        self.exit(EXIT_BAD_INPUT, f"{self.prog}: error: {message} (see {self.prog} --help)\n")


def _number(kind: type[int] | type[float], allowed: str) -> Callable[[str], float]:
    def number(text: str) -> float:
        try:
            return kind(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"must be {allowed}, got {text!r}") from None

    return number


def build_parser(prog: str, description: str, package: str, commands: Sequence[str]) -> argparse.ArgumentParser:
    """Build the parser of one console command from its sub-command modules."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = _Parser(prog=prog, description=description, formatter_class=raw)
    parser.add_argument("--version", action="version", version=f"knitbench {knitbench_version()}")
    subparsers = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name in commands:
        module = importlib.import_module(f"{package}.{name.replace('-', '_')}")
        epilog = f"example:\n  {module.EXAMPLE}"
        sub = subparsers.add_parser(
            name, help=module.SUMMARY, description=module.SUMMARY, epilog=epilog, formatter_class=raw
        )
        module.add_arguments(sub)
        in_place = getattr(module, "IN_PLACE", {})
        options = {action.dest.lower(): action.option_strings[-1] for action in sub._actions if action.option_strings}
        sub.set_defaults(run=module.run, command=f"{prog} {name}", in_place=in_place, options=options)
    return parser


def main(prog: str, description: str, package: str, commands: Sequence[str], argv: Sequence[str] | None) -> int:
    """Run one sub-command; bad input becomes one sentence on stderr and exit code 2."""
    streams.make_ready()
    for name, value in KEPT_OUT.items():
        os.environ.setdefault(name, value)
    os.environ["MPLBACKEND"] = "agg"  # pictures go to files; a notebook's backend may not be there in its shell
    words = list(sys.argv[1:] if argv is None else argv)
    # Only the called sub-command is imported; --help needs them all.
    chosen = [words[0]] if words and words[0] in commands else list(commands)
    with contextlib.redirect_stderr(cast(TextIO, streams.Remarks(sys.stderr))):
        try:
            parser = build_parser(prog, description, package, chosen)
            args, others = parser.parse_known_args(words)
            if others:
                parser.prog = args.command  # whose help has the options that there are
                parser.error(f"unrecognized arguments: {' '.join(others)}")
            return _run(args, words)
        except KeyboardInterrupt:
            print(f"{' '.join([prog, *chosen[: len(chosen) == 1]])}: interrupted", file=sys.stderr)
            return EXIT_INTERRUPTED


def _run(args: argparse.Namespace, words: Sequence[str]) -> int:
    _OPTIONS.clear()
    _OPTIONS.update(args.options)
    try:
        check_environment()
        check_words(words)
        check_apart(args)
        with contextlib.redirect_stdout(cast(TextIO, _Printable(sys.stdout))):
            code = int(args.run(args) or 0)
            sys.stdout.flush()  # here, where it is known what to do if nobody takes it
        return code
    except UserError as error:
        return _fail(args.command, str(error))
    except MemoryError:
        return _fail(args.command, "this needs more memory than there is; give less at once, or a lower rate")
    except OSError as error:
        return _fail(args.command, f"{error.filename or 'system'}: {error.strerror or error}")
    except RuntimeError as error:
        # How pathlib of Python 3.11 and 3.12 says what the system calls ELOOP.
        if "Symlink loop" not in str(error):
            raise
        return _fail(args.command, f"{error}; give a file or a folder that is one")
    except ValueError as error:
        if type(error).__name__ != "ValidationError":
            raise
        return _fail(args.command, first_problem(error))


def given(args: argparse.Namespace, names: Iterable[str]) -> dict[str, Any]:
    """What was said of these options, by the parameter that each sets."""
    return {name: getattr(args, name) for name in names if getattr(args, name) is not None}


def whole(low: int, high: float = float("inf")) -> Callable[[str], int]:
    """argparse type: a whole number from `low` to `high`."""
    allowed = f"a whole number, {low} or more" if high == float("inf") else f"a whole number from {low} to {high}"

    def number(text: str) -> int:
        if not re.fullmatch(r"\d{1,18}", text, re.ASCII) or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"must be {allowed}, got {text!r}")
        return int(text)

    return number


processes = whole(1, MOST_PROCESSES)  # argparse type of --workers


def check_environment() -> None:
    """Refuse what libraries would not take from the environment; see `NUMBERS`."""
    for name, (low, high) in NUMBERS.items():
        try:
            whole(low, high)(os.environ.get(name, str(low)))
        except argparse.ArgumentTypeError as error:
            raise UserError(f"{name} in the environment {error}; unset it, or mend it") from None


def check_words(words: Sequence[str]) -> None:
    """Refuse ``--option=--``, of which argparse makes an empty list, and a zero byte, which no file's name has."""
    if found := [word for word in words if "\0" in word]:
        raise UserError(f"{found[0][:100]}: a zero byte stands in it")
    if found := [word for word in words if word.startswith("-") and word.endswith("=--")]:
        raise UserError(f"{found[0]}: -- is no value; it stands alone, before words that begin with a dash")


def check_apart(args: argparse.Namespace) -> None:
    """Refuse a file that is read and would be written over, or would be written twice.

    Raises
    ------
    UserError
        If two arguments name one file, at least one of them for writing.
    """
    taken: dict[tuple[int, int] | str, str] = {}
    for name, value in sorted(vars(args).items(), key=lambda item: item[0] in WRITTEN):
        for word in value if isinstance(value, list) else [value]:
            place = _file(word, name in WRITTEN) if isinstance(word, str) and name not in WORDS else None
            if place in taken and name in WRITTEN and args.in_place.get(name) != taken[place]:
                why = "would be written twice" if taken[place] in WRITTEN else "is read, and would be written over"
                raise UserError(f"{word}: {why}; give another place")
            if place is not None:
                taken[place] = name


def _file(word: str, written: bool) -> tuple[int, int] | str | None:
    """What is the same for all names of a file; None for what is none, but for one that will be written."""
    try:
        found = os.stat(word)
    except (OSError, ValueError):
        return os.path.abspath(word) if written and word not in ("", "-") else None
    return (found.st_dev, found.st_ino) if stat.S_ISREG(found.st_mode) else None


def _fail(command: str, message: str) -> int:
    message = message.removeprefix(f"{command.split()[-1]}: ")  # a function that is called like its command
    message = _SUBJECT.sub(lambda name: _OPTIONS.get(name[1].lower(), name[0]), message)
    print(f"{command}: error: {printable(message)}", file=sys.stderr)
    return EXIT_BAD_INPUT


def printable(text: str) -> str:
    """`text` with what would steer a terminal escaped: messages quote files, and files come from strangers.

    Parameters of Python are named as options of the command that runs.
    """
    text = re.sub(r"`(\w+)`", lambda name: _OPTIONS.get(name[1].lower(), name[0]), text)
    if text.replace("\n", "").replace("\t", "").isprintable():
        return text
    return "".join(char if char.isprintable() or char in "\n\t" else ascii(char)[1:-1] for char in text)


class _Printable(streams.Beside):
    """A stream that is written to through `printable`, which shows names that are no text (lone surrogates), too.

    Where its reader has gone (head, less), which is its right, the work goes on: to its files and its exit code.
    """

    def write(self, text: str) -> int:
        """Write what may be shown."""
        return super().write(printable(text))

    def _act(self, call: Callable[[], object]) -> None:
        try:
            call()
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())


class Progress:
    """A progress line on stderr with the time left; silent where nobody watches.

    With ``KNITBENCH_PROGRESS=json`` in the environment it prints one JSON object a step instead, for a program that
    watches (the studio does).

    Parameters
    ----------
    label : str
        What is being done.
    total : int
        Number of steps.
    """

    def __init__(self, label: str, total: int) -> None:
        self.label, self.total, self.done = label, max(total, 1), 0
        self._start = time.monotonic()
        self._live = sys.stderr.isatty()
        self._json = os.environ.get("KNITBENCH_PROGRESS") == "json"

    def step(self, note: str = "") -> None:
        """Count one step as done and redraw."""
        self.done += 1
        if self._json:
            event = {"label": self.label, "done": self.done, "total": self.total, "note": note}
            print(json.dumps(event), file=sys.stderr, flush=True)
            return
        if not self._live:
            return
        elapsed = time.monotonic() - self._start
        left = elapsed / self.done * (self.total - self.done)
        end = "\n" if self.done >= self.total else ""
        text = f"{self.label}: {self.done}/{self.total}, {left:.0f} s left {note}"
        print(streams.redrawn(text), end=end, file=sys.stderr, flush=True)
