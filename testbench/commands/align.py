"""``testbench align``: the delay and drift between a program and what was recorded of it."""

from __future__ import annotations

import argparse
from pathlib import Path

from testbench.commands._arguments import existing_file, positive

SUMMARY = "find delay and clock drift between the planned and the recorded displacement, and apply them"
EXAMPLE = "testbench align knit-7 -o knit-7-aligned"


def add_arguments(parser: argparse.ArgumentParser) -> None:

    parser.add_argument("recording", metavar="RECORDING", help="campaign folder, or a CSV with --program")
    parser.add_argument("--program", metavar="FILE", help="default: the campaign's own")
    parser.add_argument("--gauge-length-mm", type=positive, metavar="L", help="of a bare CSV")
    parser.add_argument("-o", dest="out", metavar="CAMPAIGN", help="write the recording on the plan's clock")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    parser.add_argument("--overwrite", action="store_true", help="replace an earlier result in that folder")


def run(args: argparse.Namespace) -> int:
    import json
    from dataclasses import asdict

    from testbench.campaigns.alignment import align, applied
    from testbench.campaigns.campaign import vacant, write_derived
    from testbench.campaigns.plan import PROGRAM
    from testbench.recordings.files import read_recording
    from testbench.rig.motion import played

    path = Path(args.recording)
    program = existing_file(args.program or path / PROGRAM, "program; name it with --program")
    recording = read_recording(path, args.gauge_length_mm)
    recording.needs_displacement()
    motion, _ = played(program, recording.gauge_length_mm)
    found = align(recording, motion)
    if args.json:
        print(json.dumps(asdict(found)))
    else:
        print(f"{path}: the plan began {round(found.delay_s, 3) + 0.0:.3f} s after the recording")
        print(f"{path}: the plan's clock runs {found.drift_ppm:+.0f} ppm fast against the recorder's")
        print(f"{path}: aligned, correlation {found.correlation:.5f}, difference {found.rms_mm * 1e3:.1f} um rms")
    if args.out:
        vacant(Path(args.out), args.overwrite)
        write_derived(Path(args.out), applied(recording, motion, found), "aligned", asdict(found), program)
        if not args.json:
            print(f"{args.out}: the recording on the plan's clock, the planned displacement beside it")
    return 0
