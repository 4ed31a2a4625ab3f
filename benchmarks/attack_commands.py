"""Attack every sub-command as a stranger would: every wrong file in every place, every wrong word in every option.

Each case must end within `HANGS_AFTER_CPU_S` with exit code 0, 1 or 2, without a traceback, with a sentence where it
is 2, and with every recording as it was. Prints a row a command, and each case that did not; exits with 1 if there is
one. Run by root, it gives up what lets root read and write everything. `tests/fuzz/test_every_command.py` runs
a share.

    python benchmarks/attack_commands.py                  # all of it, hours
    python benchmarks/attack_commands.py --only gcode     # one package, or "gcode check" "testbench fit"
    python benchmarks/attack_commands.py --each 7         # every seventh case
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import importlib
import io
import os
import shutil
import signal
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from wrong_files import wrong_files

HANGS_AFTER_S, HANGS_AFTER_CPU_S = 1800, 200  # of waiting, and of work: far above what a slow or busy machine takes
NUMBERS = ("nan", "inf", "-inf", "-1", "0", "1e300", "-1e300", "1e-300", "9" * 400, "0x10", "1_0", "", "x", "١")
TEXTS = (
    "", " ", "-", "--", "x", "\x1b[31mred", "a" * 100_000, "knitted é 编织", "\udcff", "../../x", "/", "%s{}",
    "a=b=c", ",", "1,,2", "nan,nan", "0", "-1", "1e400", "9" * 400, "['a']", "a\nb", "\0",
)  # fmt: skip
# {name} is a place for a file; each is replaced by every file of the zoo in turn, the others by a good one.
COMMANDS = {
    "gcode check": "{program} --v-max 5 --a-max 20 --x-min -1 --x-max 10",
    "gcode play": "{program} -o {out}",
    "gcode generate": "--spec {spec} --seed 1 --gauge-length-mm 25 -o {out}",
    "gcode generate ": "--again {program} -o {out}",
    "gcode generate  ": "--preset paper-1 --seed 1 --duration-s 20 --gauge-length-mm 25 -o {out}",
    "gcode fit": "--v-mean 0 --v-sd 1 --a-mean 0 --a-sd 10 -o {out}",
    "testbench fit": "{recording} --gauge-length-mm 25 --model {model} --held-out {recording} -o {out}",
    "testbench compare": "{recording} --model {model} --gauge-length-mm 25",
    "testbench diagnose": "{recording} {second} --held-out {third} --gauge-length-mm 25 --rest-s 60 "
    "--clamp-play-mm 0.3 --repeat 1 --quiet --json {out}",
    "testbench diagnose ": "{recording} --gauge-length-mm 25 --held-out {second} --model {model} --json {out}",
    "testbench propose": "{recording} --gauge-length-mm 25 --model {model} --quiet -o {law}",
    "testbench add": "hysteresis --model {model} --fit {recording} --gauge-length-mm 25 -o {out}",
    "testbench ladder": "{model}",
    "testbench experiment": "{model} {rival} --duration-s 120",
    "testbench experiment ": "--diagnosis {diagnosis} --fit {recording} --gauge-length-mm 25 --duration-s 120",
    "testbench report": "--recording {recording} --gauge-length-mm 25 --diagnosis {diagnosis} -o {out}",
    "testbench fit ": "{recording} --gauge-length-mm 25 --effects {effects} -o {out}",
    "testbench compare ": "{campaign} --model {model} --effects {effects}",
    "testbench propose ": "{recording} --gauge-length-mm 25 --quiet -o {law} --plot {picture} "
    "--save-model {out} --json {page}",
    "testbench add ": "--undo --model {rival} -o {out}",
    "testbench experiment  ": "{model} {rival} --duration-s 120 -o {out} --plot {picture} --json {page}",
    "testbench report  ": "--recording {recording} --gauge-length-mm 25 --figures {out} -o {page}",
    "testbench report ": "--compensator {score} --model {model} --commands {text} -o {out}",
    "testbench investigate": "{model} --run-minutes 2 --budget-minutes 2 --sure 0.51 --trials 1 --repeat 1 --quiet "
    "-o {out}",
    "testbench investigate ": "--resume --quiet -o {investigation} --json {out}",
    "testbench verify": "{campaign}",
    "testbench align": "{campaign} --program {driven} -o {out}",
    "testbench dataset": "{dataset} -o {out} --workers 1",
    "testbench import": "{table} --gauge-length-mm 25 -o {out}",
    "testbench run ": "--program {program} --model {model} --after {campaign} --effects {effects} -o {out}",
    "testbench rig": "--program {program} --model {model} --after {campaign} --link {out} --speed 1000",
    "testbench run": "--program {program} --sensor pes -o {out}",
    "testbench record": "--port /dev/knitbench-is-not-there --program {program} -o {out}",
    "testbench record ": "--resume -o {unfinished}",
    "testbench effects ": "--effects {effects} --plot {picture} my_effect",
    "testbench effects  ": "--new another_effect -o {script}",
    "testbench hide": "--minutes 1 -o {out}",
    "testbench effects": "--effects {effects} --check",
    "compensation train": "{campaign} --target force --hidden 1 --restarts 1 -o {out}",
    "compensation train ": "{recording} --target force --gauge-length-mm 25 --twin {model} -o {out} --plot {picture}",
    "compensation score": "{compensator} {campaign} -o {out} --plot {picture}",
    "compensation table": "--seeds 2 --specimens 1 --sensor pes --quick --engine fast -o {out}",
    "compensation predict": "{campaign} --compensator {compensator} -o {out}",
    "compensation recalibrate": "{compensator} {campaign} -o {out}",
    "compensation export": "{compensator} -o {out}",
    "compensation search": "{campaign} {second} {third} --gauge-length-mm 25 --target force --sample 1 --seeds 1 "
    "--workers 1 -o {out}",
}
MADE_BY = (
    "testbench fit {recording} --gauge-length-mm 25 -o {model}",
    "testbench run --program {driven} --model {model} -o {campaign}",
    "testbench investigate {model} --run-minutes 2 --budget-minutes 2 --sure 0.51 --trials 1 --repeat 1 --quiet "
    "-o {investigation}",
    "testbench add stress_relaxation --model {model} --fit {recording} --gauge-length-mm 25 -o {rival}",
    "testbench diagnose {recording} --gauge-length-mm 25 --json {diagnosis}",
    "testbench effects --new my_effect -o {effects}",
    "compensation train {campaign} --target force --hidden 1 --restarts 1 -o {compensator}",
    "compensation score {compensator} {campaign} -o {score}",
)
SERVE, SERVES_S = {"testbench rig"}, 3  # what serves until it is interrupted, and is, then
ENDS = {"picture": "png", "page": "html", "script": "py"}  # of the names of files to write
NO_ANSWER = {"testbench record", "gcode fit"}  # no device, or it would take long
NO_NUMBERS = {"--port", "--seeds", "--restarts", "--scheduler", "--minutes"}  # these would only take long


class Hung(BaseException):
    """A case did not end."""


def good_files(folder: Path) -> dict[str, Path]:
    """A small good file for each place: made by the commands themselves, so that every loader takes it."""
    from gcode.trajectories.trajectory import spec_to_toml
    from tests.fuzz.targets import DATASET, SPEC, TABLE, samples
    from tests.testbench.builders import record, truth, write_csv
    from tests.testbench.rig.rigs import PROGRAM_TEXT, program

    program(folder)
    texts = {
        "program.tap": samples()["program"],
        "driven.tap": PROGRAM_TEXT.replace("M30", "G1 X5 F120\nG1 X0 F120\n" * 12 + "M30"),
        "spec.toml": spec_to_toml(SPEC),
        "table.csv": TABLE.decode(),
        "text.json": "testbench fit mine\n",
        "dataset.toml": DATASET,
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    (folder / "unfinished").mkdir()
    for name, data in samples()["files"].items():
        (folder / "unfinished" / name).write_bytes(data)
    paths = {name.partition(".")[0]: folder / name for name in texts}
    paths |= {name: folder / f"{name}.json" for name in ("model", "rival", "diagnosis", "score", "compensator")}
    paths |= {"recording": folder / "recording.csv", "effects": folder / "effects.py", "law": folder / "law.py"}
    paths |= {name: folder / name for name in ("campaign", "unfinished", "investigation")}
    paths |= {name: folder / f"{name}.csv" for name in ("second", "third")}
    for seed, name in enumerate(("recording", "second", "third")):
        write_csv(record(truth(), 30, seed=seed), paths[name])
    for command in MADE_BY:
        sub, *words = command.format(**paths).split()[1:]
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as said:
            code = importlib.import_module(f"{command.split()[0]}.cli").main([sub, *words])
        if code:
            raise RuntimeError(f"{command}: {said.getvalue()}")
    (folder / "knit.json").write_bytes(paths["model"].read_bytes())
    return paths


class Case(NamedTuple):
    """One call: the command, its words, what is wrong with them, and whether what was written before is kept."""

    command: str
    words: list[str]
    wrong: str
    again: bool = False


def cases(only: Sequence[str], good: dict[str, Path], bad: dict[str, Path], out: Path) -> Iterator[Case]:
    """Every wrong file in every place, every wrong word behind every option, all twice, and all once more."""
    for template_of, template in COMMANDS.items():
        if not template_of.startswith(tuple(only)):
            continue
        program, sub = template_of.split()[:2]
        command, slots = f"{program} {sub}", template.split()
        places = good | {"out": out}
        places |= {name: out.with_name(f"out.{end}") for name, end in ENDS.items()}
        filled = [str(places[word[1:-1]]) if word.startswith("{") else word for word in slots]
        yield Case(command, [sub, *filled], "nothing")
        yield Case(command, [sub, *filled], "what is written is there", again=True)
        yield Case(command, [sub, *filled, *filled], "all twice")
        for place, word in enumerate(slots):
            for name, path in bad.items() if word.startswith("{") else ():
                yield Case(command, [sub, *filled[:place], str(path), *filled[place + 1 :]], f"{word}: {name}")
        # A second way to call a sub-command has the same options as the first.
        for option, words in _options(program, sub) if not template_of.endswith(" ") else ():
            for word in words:
                yield Case(command, [sub, *filled, f"{option}={word}"], f"{option} {word[:10]!a}")


def _options(program: str, sub: str) -> Iterator[tuple[str, Sequence[str]]]:
    """Each option that takes a value, with the words that are none."""
    parser = argparse.ArgumentParser()
    importlib.import_module(f"{program}.commands.{sub}").add_arguments(parser)
    for action in parser._actions:
        if action.option_strings and action.nargs != 0 and not NO_NUMBERS & {*action.option_strings}:
            yield action.option_strings[-1], NUMBERS if action.type else TEXTS


class Kept:
    """The files of a folder as they were, to see what a case has changed, and to put it back."""

    def __init__(self, folder: Path, recorded: Sequence[Path]) -> None:
        files = [path for path in folder.rglob("*") if path.is_file() and not path.is_symlink()]
        self._files = {
            path: (self._state(path), path.read_bytes()) for path in files if path.stat().st_size < 1 << 24
        }
        self._recorded = {path for path in files if any(place in (path, *path.parents) for place in recorded)}

    def lost(self) -> list[str]:
        """Recordings that are not as they were; everything is put back."""
        lost = []
        for path, (state, data) in self._files.items():
            if self._state(path) == state:
                continue
            if path in self._recorded and (not path.is_file() or path.read_bytes() != data):
                lost.append(path.name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.unlink(missing_ok=True)
            path.write_bytes(data)
            self._files[path] = self._state(path), data
        return lost

    @staticmethod
    def _state(path: Path) -> tuple[int, ...]:
        try:
            found = path.lstat()
        except OSError:
            return ()
        return found.st_ino, found.st_size, found.st_mtime_ns


@contextlib.contextmanager
def an_ordinary_user() -> Iterator[None]:
    """Take from root what reads and writes past all permissions (CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH)."""
    libc = ctypes.CDLL(None, use_errno=True)
    header, sets = (ctypes.c_uint32 * 2)(0x20080522, 0), (ctypes.c_uint32 * 6)()
    if os.geteuid() or libc.capget(header, sets):
        yield
        return
    before = sets[0]
    sets[0] = before & ~0b110
    libc.capset(header, sets)
    try:
        yield
    finally:
        sets[0] = before
        libc.capset(header, sets)


def attacked(command: str, words: list[str], good: bool = False) -> str:
    """What went wrong; empty if the command answered as it should, which is an answer where all was `good`."""
    main = importlib.import_module(f"{command.split()[0]}.cli").main
    said, told = (io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in range(2))
    said.reconfigure(errors="backslashreplace")  # as Python's own are

    def hung(*_: object) -> None:
        raise Hung

    serves = command in SERVE
    signal.signal(signal.SIGALRM, signal.default_int_handler if serves else hung)
    signal.signal(signal.SIGPROF, hung)
    signal.alarm(SERVES_S if serves else HANGS_AFTER_S)
    signal.setitimer(signal.ITIMER_PROF, HANGS_AFTER_CPU_S)
    try:
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(said), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            code = main(words)
    except SystemExit as end:
        code = end.code
    except Hung:
        return f"still running after {HANGS_AFTER_CPU_S} s of work, or {HANGS_AFTER_S} s of waiting"
    except BaseException as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__}: {str(error)[:100]} ({Path(last.filename).name}:{last.lineno})"
    finally:
        signal.alarm(0)
        signal.setitimer(signal.ITIMER_PROF, 0)
    told, said = (stream.buffer.getvalue().decode() for stream in (told, said))
    interrupted = serves and code == 130  # as it should end
    return _fault(0 if interrupted else code, told, said, good)


def _fault(code: object, told: str, said: str, good: bool) -> str:
    """What is wrong with an answer; empty if nothing is."""
    if code not in (0, 1, 2):
        return f"exit code {code!r}"
    if "Traceback" in said:
        return "a traceback on stderr"
    if "\x1b" in said or "\x1b" in told:
        return "escape codes of a stranger on the terminal"
    if code == 2 and "error: " not in said:
        return "exit code 2 without a sentence"
    if code == 1 and not (said.strip() or told.strip()):
        return "exit code 1 without a word"
    return f"exit code {code}: {said.strip()[:200]}" if code and good else ""


class Attack:
    """Good files and wrong ones in a folder of their own, and every case that is made of them."""

    def __init__(self, folder: Path, only: Sequence[str] = ("",)) -> None:
        self._folder = folder
        good = good_files(folder)
        bad = wrong_files(folder / "zoo", good)
        self.cases = list(cases(only, good, bad, folder / "out"))
        self._kept = Kept(
            folder, [good[name] for name in ("recording", "second", "third", "campaign", "investigation")]
        )

    def fault(self, case: Case) -> str:
        """What is wrong with how a case ends; empty if nothing is."""
        if not case.again:
            for place in self._folder.glob("out*"):
                shutil.rmtree(place) if place.is_dir() and not place.is_symlink() else place.unlink()
        with an_ordinary_user():
            fault = attacked(case.command, case.words, case.wrong == "nothing" and case.command not in NO_ANSWER)
        lost = self._kept.lost()
        return fault or (f"lost: {', '.join(lost)}" if lost else "")


def main() -> int:
    """Run; print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default=("",), nargs="+", help="packages, or packages and commands")
    parser.add_argument("--each", type=int, default=1, metavar="N", help="every Nth case alone")
    args = parser.parse_args()
    os.environ["OMP_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        attack = Attack(Path(name), args.only)
        count, wrong = Counter(), Counter()
        for number, case in enumerate(attack.cases):
            if number % args.each:
                continue
            count[case.command] += 1
            if fault := attack.fault(case):
                wrong[case.command] += 1
                print(f"case {number}: {case.command}, {case.wrong!a}: {fault!a}", flush=True)
        width = max(map(len, count))
        print(f"{'command':{width}}  cases  faults")
        for command, cases_of in count.items():
            print(f"{command:{width}}  {cases_of:5}  {wrong[command]:6}")
        print(f"{'all':{width}}  {count.total():5}  {wrong.total():6}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
