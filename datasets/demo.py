"""The main job, end to end: plan, run, compensate, understand, report.

Run by ``make demo``. Everything it does is a command that a user can give too; each is printed before it runs.
What is there and verifies is not made again.
"""

from __future__ import annotations

import argparse
import json
import shlex
import sys
import time
from pathlib import Path
from statistics import mean

import compensation.cli
import gcode.cli
import testbench.cli
from compensation.paper.published import COMPENSATED, RAW

MAINS = {"gcode": gcode.cli.main, "testbench": testbench.cli.main, "compensation": compensation.cli.main}
TRAJECTORIES = (("paper-1", 51), ("paper-2", 52), ("paper-3", 53))
SENSORS = ("pes", "lycra")
GAUGE_LENGTH_MM = 25
LIMITS = ("--v-max", "6", "--a-max", "25", "--x-min", "-0.1", "--x-max", "8")
HIDDEN = ("--effect", "stress_relaxation", "--world", "mismatched", "--strength", "5", "--seed", "7")


def do(*words: object, may_fail: bool = False) -> int:
    """Print a command and run it in this process; stop the demo if it fails."""
    line = [str(word) for word in words]
    print(f"\n$ {shlex.join(line)}", flush=True)
    code = MAINS[line[0]](line[1:])
    if code and not may_fail:
        sys.exit(code)
    return code


def kept(target: Path, *sources: Path) -> bool:
    """Whether `target` is newer than all it was made from; then it is not made again (`make clean` starts over)."""
    newest = max(source.stat().st_mtime for source in sources)
    if not target.exists() or target.stat().st_mtime < newest:
        return False
    print(f"  {target} is newer than what it was made from, so it is kept")
    return True


def heading(number: int, text: str) -> None:
    """Say which step begins."""
    print(f"\n=== {number}. {text}", flush=True)


def plan(folder: Path) -> list[Path]:
    """Three 23 min trajectories with the paper's statistics, as Mach4 programs."""
    programs = []
    for preset, seed in TRAJECTORIES:
        program = folder / preset / "program.tap"
        if not program.exists() or do("gcode", "check", program, *LIMITS, may_fail=True) != 0:
            do("gcode", "generate", "--preset", preset, "--seed", seed, "--gauge-length-mm", GAUGE_LENGTH_MM,
               "-o", program.parent)  # fmt: skip
        programs.append(program)
    return programs


def run(folder: Path, programs: list[Path]) -> dict[str, list[Path]]:
    """Six simulated campaigns: two sensors, each through three trajectories, one after another."""
    campaigns: dict[str, list[Path]] = {sensor: [] for sensor in SENSORS}
    for sensor in SENSORS:
        for number, program in enumerate(programs, 1):
            campaign = folder / f"{sensor}-{number}"
            after = ("--after", campaigns[sensor][-1]) if campaigns[sensor] else ()
            # Does nothing where this very campaign is there and intact.
            do("testbench", "run", "--sensor", sensor, "--program", program, "--seed", number, *after,
               "-o", campaign, "--overwrite")  # fmt: skip
            campaigns[sensor].append(campaign)
    return campaigns


def compensate(folder: Path, campaigns: dict[str, list[Path]]) -> Path:
    """Train on the first recording of each sensor, score on the other two; print the paper's table beside ours."""
    folder.mkdir(parents=True, exist_ok=True)
    for sensor, (first, *others) in campaigns.items():
        for target in ("force", "displacement"):
            name = folder / f"{sensor}-{target}"
            if not kept(Path(f"{name}.json"), first / "recording.csv"):
                do("compensation", "train", first, "--target", target, "-o", f"{name}.json")
            do("compensation", "score", f"{name}.json", first, *others, "-o", f"{name}-score.json")
    print_beside_the_paper(folder)
    return folder / f"{SENSORS[0]}-force-score.json"


def print_beside_the_paper(folder: Path) -> None:
    """The paper's r2 before and after compensation, and ours, for the recordings T (training), A and B."""
    print("\nr2 as the paper defines it               paper                 here")
    print("sensor  target        recording  before   after*     before    after")
    for sensor in SENSORS:
        for target in ("force", "displacement"):
            before, after = RAW[sensor, target], mean(COMPENSATED[sensor, target][1:])
            score = json.loads((folder / f"{sensor}-{target}-score.json").read_text())
            for letter, published, ours in zip("TAB", before, score["recordings"], strict=True):
                shown = f"{after:>8.2f}" if letter != "T" else "        "
                print(
                    f"{sensor:<8}{target:<14}{letter:<9}{published:>8.3f}{shown}{ours['r2_before']:>12.3f}"
                    f"{ours['r2_after']:>9.3f}"
                )
    print("* the mean of A and B, from the paper's text; ours: one simulated sensor, one network")


def understand(folder: Path) -> Path:
    """A sensor with a hidden effect: where the baseline fails, what is missing, and the fall of the error."""
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "recordings").exists():
        do("testbench", "hide", *HIDDEN, "-o", folder)
    recordings = folder / "recordings"
    pair = (recordings / "calibration.csv", "--held-out", recordings / "held_out.csv")
    gauge = ("--gauge-length-mm", GAUGE_LENGTH_MM)
    do("testbench", "fit", *pair, *gauge, "-o", folder / "baseline.json")
    do("testbench", "compare", recordings / "held_out.csv", *gauge, "--model", folder / "baseline.json")
    if not kept(folder / "model.json", recordings / "calibration.csv", recordings / "held_out.csv"):
        do("testbench", "diagnose", *pair, *gauge, "--json", folder / "diagnosis.json", "-o", folder / "model.json")
    do("testbench", "ladder", folder / "model.json")
    truth = json.loads((folder / "sealed" / "truth.json").read_text())
    print(f"\n  the seal opened: hidden was {', '.join(entry['effect'] for entry in truth['effects'])}")
    return folder


def report(out: Path, hidden: Path, score: Path) -> Path:
    """One self-contained page."""
    page = out / "report.html"
    calibration, held = (hidden / "recordings" / f"{name}.csv" for name in ("calibration", "held_out"))
    pair = ("--recording", calibration, "--held-out", held, "--gauge-length-mm", GAUGE_LENGTH_MM)
    found = ("--model", hidden / "model.json", "--diagnosis", hidden / "diagnosis.json")
    do("testbench", "report", *pair, *found, "--compensator", score, "-o", page)
    return page


def main() -> None:
    """Run all five steps."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("demo-output"))
    out: Path = parser.parse_args().output
    began = time.monotonic()
    heading(1, "plan: three 23 min trajectories, 0-30 % strain")
    programs = plan(out / "trajectories")
    heading(2, "run: two sensors on the simulated rig, six campaigns")
    campaigns = run(out / "campaigns", programs)
    heading(3, "compensate: train on the first recording of each sensor, score on the other two")
    score = compensate(out / "compensators", campaigns)
    heading(4, "understand: a sensor with a hidden effect")
    hidden = understand(out / "hidden-effect")
    heading(5, "report")
    page = report(out, hidden, score)
    print(f"\ndone in {time.monotonic() - began:.0f} s; open {page}")


if __name__ == "__main__":
    main()
