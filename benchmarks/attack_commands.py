"""Attack every sub-command as a stranger would: every kind of wrong file in every place, every wrong number.

Each case must end within `HANGS_AFTER_CPU_S` with exit code 0, 1 or 2 and without a traceback. Prints a row a
command, and each case that did not; exits with 1 if there is one.

    python benchmarks/attack_commands.py                  # all of it, some minutes
    python benchmarks/attack_commands.py --only gcode     # one package, or "gcode check" "testbench fit"
"""

from __future__ import annotations

import argparse
import contextlib
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

HANGS_AFTER_S, HANGS_AFTER_CPU_S = 600, 60  # the first is for waiting, and far above what a busy machine takes
NUMBERS = ("nan", "inf", "-inf", "-1", "0", "1e300", "-1e300", "1e-300", "9" * 400, "0x10", "1_0", "", "x", "١")
# {name} is a place for a file; each is replaced by every file of the zoo in turn, the others by a good one.
COMMANDS = {
    "gcode check": "{program} --v-max 5 --a-max 20 --x-min -1 --x-max 10",
    "gcode play": "{program} -o {out}",
    "gcode generate": "--spec {spec} --seed 1 -o {out}",
    "gcode generate ": "--again {program} -o {out}",
    "gcode generate  ": "--preset paper-1 --seed 1 --duration-s 20 -o {out}",
    "gcode fit": "--v-mean 0 --v-sd 1 --a-mean 0 --a-sd 10 -o {out}",
    "testbench fit": "{recording} --gauge-length-mm 25 --model {model} --held-out {recording} -o {out}",
    "testbench compare": "{recording} --model {model} --gauge-length-mm 25",
    "testbench diagnose": "{recording} --gauge-length-mm 25 --held-out {recording} --model {model} --json {out}",
    "testbench propose": "{recording} --gauge-length-mm 25 --model {model} --quiet -o {law}",
    "testbench add": "hysteresis --model {model} --fit {recording} --gauge-length-mm 25 -o {out}",
    "testbench ladder": "{model}",
    "testbench experiment": "{model} {rival} --duration-s 120",
    "testbench experiment ": "--diagnosis {diagnosis} --fit {recording} --gauge-length-mm 25 --duration-s 120",
    "testbench report": "--recording {recording} --gauge-length-mm 25 --diagnosis {diagnosis} -o {out}",
    "testbench report ": "--compensator {score} --model {model} --commands {text} -o {out}",
    "testbench investigate ": "--resume --quiet -o {campaign} --json {out}",
    "testbench verify": "{campaign}",
    "testbench align": "{campaign} --program {driven} -o {out}",
    "testbench dataset": "{dataset} -o {out} --workers 1",
    "testbench import": "{table} --gauge-length-mm 25 -o {out}",
    "testbench run": "--program {program} --sensor pes -o {out}",
    "testbench record": "--port /dev/knitbench-is-not-there --program {program} -o {out}",
    "testbench record ": "--resume -o {unfinished}",
    "testbench hide": "--minutes 1 -o {out}",
    "testbench effects": "--effects {effects} --check",
    "compensation train": "{campaign} --target force --hidden 1 --restarts 1 -o {out}",
    "compensation score": "{compensator} {campaign} -o {out}",
    "compensation predict": "{campaign} --compensator {compensator} -o {out}",
    "compensation recalibrate": "{compensator} {campaign} -o {out}",
    "compensation export": "{compensator} -o {out}",
    "compensation search": "{campaign} {campaign} {campaign} --target force --sample 1 --seeds 1 --workers 1 "
    "-o {out}",
}
MADE_BY = (
    "testbench run --program {driven} --sensor pes -o {campaign}",
    "testbench fit {recording} --gauge-length-mm 25 -o {model}",
    "testbench add stress_relaxation --model {model} --fit {recording} --gauge-length-mm 25 -o {rival}",
    "testbench diagnose {recording} --gauge-length-mm 25 --json {diagnosis}",
    "testbench effects --new my_effect -o {effects}",
    "compensation train {campaign} --target force --hidden 1 --restarts 1 -o {compensator}",
    "compensation score {compensator} {campaign} -o {score}",
)
NO_NUMBERS = {
    "--port",
    "--workers",
    "--seeds",
    "--restarts",
    "--scheduler",
    "--minutes",
}  # these would only take long


class Hung(BaseException):
    """A case did not end."""


def good_files(folder: Path) -> dict[str, Path]:
    """A small good file for each place: made by the commands themselves, so that every loader takes it."""
    from gcode.trajectories.toml_spec import spec_to_toml
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
    paths |= {"campaign": folder / "campaign", "unfinished": folder / "unfinished"}
    write_csv(record(truth(), 30), paths["recording"])
    for command in MADE_BY:
        sub, *words = command.format(**paths).split()[1:]
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as said:
            code = importlib.import_module(f"{command.split()[0]}.cli").main([sub, *words])
        if code:
            raise RuntimeError(f"{command}: {said.getvalue()}")
    (folder / "knit.json").write_bytes(paths["model"].read_bytes())
    return paths


def zoo(folder: Path, good: dict[str, Path]) -> dict[str, Path]:
    """Every kind of file that is not what was asked for."""
    folder.mkdir()
    whole = {
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
    found = {}
    for name, data in whole.items():
        for end in ("csv", "json", "xlsx", "tdms") if "none" in name else ("x",):
            found[f"{name}.{end}"] = folder / f"{name}.{end}"
            found[f"{name}.{end}"].write_bytes(data)
    for name, path in good.items():
        if path.is_file():
            found[f"a {name}"] = path
            cut = folder / f"half a {path.name}"
            cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
            found[cut.name] = cut
    os.mkfifo(folder / "pipe")
    (folder / "loop").symlink_to(folder / "loop")
    (folder / "to nowhere").symlink_to(folder / "nowhere")
    (folder / "a folder").mkdir()
    (folder / "a\nb\x1b[31m.csv").write_bytes(b"x")
    for name in ("pipe", "loop", "to nowhere", "a folder", "a\nb\x1b[31m.csv", "missing", "pipe/below", "n" * 300):
        found[name] = folder / name
    folders = _campaigns(folder, good["campaign"])
    devices = {name: Path(name) for name in ("/dev/zero", "/dev/full", "/dev/null", "/proc/self/mem", "/")}
    return found | folders | devices


def _campaigns(folder: Path, good: Path) -> dict[str, Path]:
    """Campaign folders in which one file is wrong."""
    found = {}

    def changed(name: str) -> Path:
        found[f"campaign: {name}"] = folder / f"campaign {name}"
        shutil.copytree(good, folder / f"campaign {name}")
        return folder / f"campaign {name}"

    for file in ("datapackage.json", "recording.csv", "program.tap", "events.jsonl"):
        (changed(f"no {file}") / file).unlink()
        place = changed(f"a pipe for {file}") / file
        place.unlink()
        os.mkfifo(place)
        place = changed(f"a link loop for {file}") / file
        place.unlink()
        place.symlink_to(place)
        place = changed(f"a folder for {file}") / file
        place.unlink()
        place.mkdir()
        place = changed(f"half of {file}") / file
        place.write_bytes(place.read_bytes()[: place.stat().st_size // 2])
        place = changed(f"one bit of {file}") / file
        data = bytearray(place.read_bytes())
        data[len(data) // 2] ^= 1
        place.write_bytes(data)
    return found


def cases(
    only: Sequence[str], good: dict[str, Path], bad: dict[str, Path], out: Path
) -> Iterator[tuple[str, list[str], str]]:
    """Command, words, and what is wrong with them."""
    for command, template in COMMANDS.items():
        if not command.startswith(tuple(only)):
            continue
        program, sub = command.split()[:2]
        slots = template.split()
        filled = [str((good | {"out": out})[word[1:-1]]) if word.startswith("{") else word for word in slots]
        for place, word in enumerate(slots):
            for name, path in bad.items() if word.startswith("{") else ():
                yield f"{program} {sub}", [sub, *filled[:place], str(path), *filled[place + 1 :]], f"{word}: {name}"
        # A second way to call a sub-command has the same options as the first.
        for option in _number_options(program, sub) if not command.endswith(" ") else ():
            for number in NUMBERS:
                yield f"{program} {sub}", [sub, *filled, f"{option}={number}"], f"{option} {number[:10]}"


def _number_options(program: str, sub: str) -> list[str]:
    parser = argparse.ArgumentParser()
    importlib.import_module(f"{program}.commands.{sub}").add_arguments(parser)
    return [
        a.option_strings[-1]
        for a in parser._actions
        if a.type and a.option_strings and not NO_NUMBERS & {*a.option_strings}
    ]


def attacked(command: str, words: list[str]) -> str:
    """What went wrong; empty if the command answered as it should."""
    main = importlib.import_module(f"{command.split()[0]}.cli").main
    said, told = io.StringIO(), io.StringIO()

    def hung(*_: object) -> None:
        raise Hung

    signal.signal(signal.SIGALRM, hung)
    signal.signal(signal.SIGPROF, hung)
    signal.alarm(HANGS_AFTER_S)
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
    if code not in (0, 1, 2):
        return f"exit code {code!r}"
    if "Traceback" in said.getvalue():
        return "a traceback on stderr"
    if "\x1b" in said.getvalue() or "\x1b" in told.getvalue():
        return "escape codes of a stranger on the terminal"
    return (
        "" if code == 0 or said.getvalue().strip() or told.getvalue().strip() else f"exit code {code} without a word"
    )


def main() -> int:
    """Run; print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default=("",), nargs="+", help="packages, or packages and commands")
    args = parser.parse_args()
    sys.path.insert(0, str(Path(__file__).parents[1]))
    os.environ["OMP_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        folder = Path(name)
        good = good_files(folder)
        bad = zoo(folder / "zoo", good)
        count, wrong = Counter(), Counter()
        for number, (command, words, what) in enumerate(cases(args.only, good, bad, folder / "out")):
            shutil.rmtree(folder / "out", ignore_errors=True)
            (folder / "out").unlink(missing_ok=True)
            count[command] += 1
            if fault := attacked(command, words):
                wrong[command] += 1
                print(f"case {number}: {command}, {what!a}: {fault}", flush=True)
        width = max(map(len, count))
        print(f"{'command':{width}}  cases  faults")
        for command, cases_of in count.items():
            print(f"{command:{width}}  {cases_of:5}  {wrong[command]:6}")
        print(f"{'all':{width}}  {count.total():5}  {wrong.total():6}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
