"""``testbench rig``: the simulated rig behind a serial port."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_simulation_arguments, positive, shared

SUMMARY = "put the simulated rig behind a serial port (a pseudo-terminal) and print the port"
EXAMPLE = """testbench rig --sensor pes --program program.tap --link /tmp/rig &
  testbench record --port /tmp/rig --program program.tap -o pes-1"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_simulation_arguments(parser)
    parser.add_argument("--link", metavar="PATH", help="symbolic link to the port, for a name you know beforehand")
    parser.add_argument("--speed", type=positive, default=1.0, metavar="X", help="times faster than real (default 1)")
    parser.add_argument("--faults", type=float, default=0.0, metavar="SHARE", help="share of damaged lines, 0 to 1")


def run(args: argparse.Namespace) -> int:
    import sys

    from gcode.support.files import existing_file
    from testbench.api.bench.serving import serve_rig
    from testbench.rig.acquisition.stopping import end_as_ctrl_c, what_ends_it

    def announce(port: str) -> None:
        end_as_ctrl_c()  # the link must not stay behind
        print(port, flush=True)
        print(f"rig: the motion starts when the port is opened; {what_ends_it()} ends the rig", file=sys.stderr)

    unheard = serve_rig(
        args.sensor or args.model,
        existing_file(args.program, "program"),
        link=args.link,
        speed=args.speed,
        faults=args.faults,
        announce=announce,
        **shared(args),
    )
    print(f"rig: the motion is over; {unheard} lines went unheard", file=sys.stderr)
    return 0
