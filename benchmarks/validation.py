"""Hold the diagnosis against public measured recordings and write the page about it.

    python benchmarks/validation.py --data DIR -o docs/validation.md --simulated r1.jsonl r2.jsonl
    python benchmarks/validation.py --data DIR -o docs/validation.md --only vhb-relax,cb-steps
    python benchmarks/validation.py --data DIR -o docs/validation.md --results DIR2    resumes where it stopped

DIR has one folder a material (`benchmarks/validation_data.py` names them); what is absent is skipped, and said so;
where all are, nothing is written.
Each pair is diagnosed in a process of its own, ended after `--limit-s`; a pair that fails is a row like any other.
Reliability comes from the results of `bench_diagnosis.py --results`. Pictures go to `images/` beside the page.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from diagnosis_score import at_a_glance, diagram, reliability
from result_rows import Row, read_rows
from validation_data import MATERIALS, Material, Pair, all_pairs
from validation_words import page

from gcode.support.files import make_folder, write_json, write_text
from gcode.support.strict import read_json
from testbench.comparing.remounting import brought_together
from testbench.diagnosis import Diagnosis, diagnose
from testbench.diagnosis.diagnosis import calibration_and_held_out
from testbench.measurements.measurement import Measurement
from testbench.recordings.versions import software_versions

LIMIT_S = 900.0
SHOWN = 6


def diagnosed(material: Material, pair: Pair, data: Path, picture: Path) -> Row:
    """One pair, read and diagnosed, and its picture."""
    start = time.perf_counter()
    every, held_out = pair.read(data / material.folder)
    found = diagnose(every, held_out, clamp_play_mm=pair.clamp_play_mm)
    _, held = calibration_and_held_out(every, held_out, pair.clamp_play_mm)
    draw(found, held, picture)
    told = found.to_dict()
    return {
        "verdict": found.verdict,
        "probabilities": dict(sorted(found.probabilities.items(), key=lambda one: -one[1])[:SHOWN]),
        "found": told["found"],
        "tied": told["tied"],
        "left": found.left,
        "error_before": told["error_before"],
        "error_after": told["error_after"],
        "noise_floor": told["noise_floor"],
        "depends_on": told["depends_on"][:3],
        "samples": sum(map(len, every)),
        "minutes": sum(one.duration_s for one in every) / 60,
        "held_out": "the last third" if held_out is None else held_out.source,
        "picture": picture.name,
        "seconds": time.perf_counter() - start,
    }


def draw(found: Diagnosis, held: Measurement, path: Path) -> None:
    """Probabilities, and what the model leaves of the held-out samples before and after."""
    from matplotlib.figure import Figure

    channels = held.channels
    figure = Figure(figsize=(10, 2.6 + 0.6 * len(channels)), layout="constrained")
    grid = figure.add_gridspec(len(channels), 2, width_ratios=(1, 2))
    bars = figure.add_subplot(grid[:, 0])
    ranked = sorted(found.probabilities.items(), key=lambda one: -one[1])[:SHOWN]
    bars.barh(range(len(ranked)), [100 * chance for _, chance in ranked], color="#0072B2")
    bars.set_yticks(range(len(ranked)), [name.replace("_", " ") for name, _ in ranked])
    bars.invert_yaxis()
    bars.set_xlim(0, 100)
    bars.set_xlabel("probability / %")
    units = {"force": "force / N", "conductance": "ln G"}
    for k, channel in enumerate(channels):
        axis = figure.add_subplot(grid[k, 1])
        for file, colour, name in ((found.before, "0.6", "before"), (found.after, "#D55E00", "after")):
            model, there = brought_together(file.model, held)
            left, counts = there.residual(model)[channel], held.counts
            axis.plot(held.grid_s[counts], (left - left[counts].mean())[counts], color=colour, lw=0.7, label=name)
        axis.set_ylabel(f"left of {units[channel]}")
        axis.margins(x=0)
        axis.legend(frameon=False, loc="upper right", fontsize=8)
    axis.set_xlabel("time / s")
    make_folder(path.parent)
    figure.savefig(path, dpi=90, metadata={"Software": None})


def in_a_process(key: str, data: Path, results: Path, picture: Path, limit_s: float) -> Row:
    """The row of one pair, made by a process that is ended after `limit_s`."""
    out = results / f"{key}.json"
    argv = [sys.executable, str(Path(__file__).resolve()), "--data", str(data), "--one", key]
    argv += ["--row", str(out), "--picture", str(picture)]
    environment = {"OMP_NUM_THREADS": "1", **os.environ}
    environment.pop("PYTHONSAFEPATH", None)  # commands set it; this script imports what lies beside it
    try:
        ended = subprocess.run(argv, capture_output=True, text=True, timeout=limit_s, env=environment, check=False)
    except subprocess.TimeoutExpired:
        return {"error": f"not ended within {limit_s:g} s"}
    if ended.returncode or not out.is_file():
        return {"error": last_line(ended.stderr) or f"ended with code {ended.returncode}"}
    return read_json(out, "result")


def last_line(text: str) -> str:
    """The last line that says something, without the paths of this machine."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return " ".join(Path(word).name if word.startswith("/") else word for word in lines[-1].split()) if lines else ""


def rows_of(args: argparse.Namespace, images: Path) -> dict[str, Row]:
    """Rows of every pair; of what is absent the reason."""
    wanted = args.only.split(",") if args.only else list(all_pairs())
    results = make_folder(args.results)
    rows: dict[str, Row] = {}
    for key, (material, _) in all_pairs().items():
        kept = results / f"{key}.json"
        if key not in wanted:
            rows[key] = {"skipped": "not asked for"}
        elif not (args.data / material.folder).is_dir():
            rows[key] = {"skipped": "these recordings are not here"}
        elif kept.is_file() and (images / picture_name(key)).is_file():
            rows[key] = read_json(kept, "result")
        else:
            rows[key] = in_a_process(key, args.data, results, images / picture_name(key), args.limit_s)
        print(f"{key}: {line_of(rows[key])}", flush=True)
    return rows


def picture_name(key: str) -> str:
    """Beside the page."""
    return f"validation-{key}.png"


def line_of(row: Mapping[str, Any]) -> str:
    """One pair in one line."""
    if "verdict" not in row:
        return str(row.get("skipped") or f"failed: {row.get('error')}")
    name, chance = next(iter(row["probabilities"].items()))
    return f"{row['verdict']}, {name} {100 * chance:.0f} %, {row['seconds']:.0f} s"


def draw_reliability(rows: Sequence[Row], path: Path) -> None:
    """How sure the first answer was over how often it was right."""
    from matplotlib.figure import Figure

    bins = diagram(rows)
    figure = Figure(figsize=(4.6, 4.2), layout="constrained")
    axis = figure.add_subplot()
    axis.plot([0, 100], [0, 100], color="0.7", lw=1, ls="--")
    axis.plot([100 * one.sure for one in bins], [100 * one.right for one in bins], color="#0072B2", marker="o")
    for one in bins:
        axis.annotate(f" {one.cases}", (100 * one.sure, 100 * one.right), va="top", fontsize=8)
    axis.set_xlabel("said with / %")
    axis.set_ylabel("right / %")
    axis.set_xlim(0, 102)
    axis.set_ylim(-2, 102)
    make_folder(path.parent)
    figure.savefig(path, dpi=90, metadata={"Software": None})


def simulated_of(paths: Iterable[Path], images: Path) -> Row | None:
    """What the benchmark's results say; None where there are none."""
    rows = [row for path in paths for row in read_rows(path) if "error" not in row]
    if not rows:
        return None
    path = images / picture_name("reliability")
    draw_reliability(rows, path)
    return {
        "cases": len(rows),
        "glance": at_a_glance(rows),
        "table": reliability(rows),
        "simulators": sorted({str(row.get("simulator")) for row in rows}),
        "strengths": sorted({float(row["strength"]) for row in rows}),
        "minutes": sorted({float(row["minutes"]) for row in rows}),
        "picture": path.name,
    }


def arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    """What to run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of the recordings, one folder a material")
    parser.add_argument("-o", "--output", type=Path, help="the page to write (docs/validation.md)")
    parser.add_argument("--simulated", type=Path, nargs="*", default=[], help="results of bench_diagnosis.py")
    parser.add_argument("--results", type=Path, default=Path("validation-results"), help="where rows are kept")
    parser.add_argument("--only", help="keys of pairs, commas between")
    parser.add_argument("--limit-s", type=float, default=LIMIT_S, help=f"for each pair (default {LIMIT_S:.0f})")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    parser.add_argument("--row", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--picture", type=Path, help=argparse.SUPPRESS)
    args = parser.parse_args(argv)
    if not args.one and args.output is None:
        parser.error("give the page to write: -o docs/validation.md")
    unknown = set((args.only or "").split(",")) - {"", *all_pairs()}
    if unknown:
        parser.error(f"--only: no pair {', '.join(sorted(unknown))}; there are {', '.join(all_pairs())}")
    return args


def main(argv: Sequence[str] | None = None) -> None:
    """Diagnose what is there and write the page."""
    args = arguments(argv)
    if args.one:
        write_json(args.row, diagnosed(*all_pairs()[args.one], args.data, args.picture))
        return
    if not any((args.data / material.folder).is_dir() for material in MATERIALS):
        print(f"skipped: none of the recordings is in {args.data}; {args.output} stays as it is")
        return
    images = args.output.parent / "images"
    rows = rows_of(args, images)
    simulated = simulated_of(args.simulated, images)
    write_text(args.output, page(MATERIALS, rows, simulated, software_versions()))
    print(f"wrote {args.output}")


if __name__ == "__main__":
    main()
