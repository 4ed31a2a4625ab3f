"""``testbench rig``: the simulated rig behind a serial port."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import natural, positive
from testbench.commands._sensors import add_past_arguments, add_sensor_arguments, sensor_model

SUMMARY = "put the simulated rig behind a serial port (a pseudo-terminal) and print the port"
EXAMPLE = "testbench rig --sensor pes --program program.tap --link /tmp/rig &\n  testbench record --port /tmp/rig ..."
HOLD_S = 3.0


def add_arguments(parser: argparse.ArgumentParser) -> None:

    add_sensor_arguments(parser)
    parser.add_argument("--program", required=True, metavar="FILE", help="Mach4 program that moves the stage")
    parser.add_argument(
        "--seed", type=natural, default=1, metavar="N", help="of noise and sampling times (default 1)"
    )
    parser.add_argument("--gauge-length-mm", type=positive, metavar="L")
    add_past_arguments(parser)
    parser.add_argument("--link", metavar="PATH", help="symbolic link to the port, for a name you know beforehand")
    parser.add_argument("--speed", type=positive, default=1.0, metavar="X", help="times faster than real (default 1)")
    parser.add_argument("--faults", type=float, default=0.0, metavar="SHARE", help="share of damaged lines, 0 to 1")


def run(args: argparse.Namespace) -> int:
    import signal
    import sys
    from pathlib import Path

    from numpy.random import default_rng

    from gcode.support.errors import UserError
    from gcode.support.files import existing_file
    from testbench.campaigns.plan import Plan, programs_before
    from testbench.rig.faults import faulty
    from testbench.rig.links import paced
    from testbench.rig.motion import played
    from testbench.rig.pty_port import PtyPort, serve
    from testbench.rig.signals import what_ends_it

    if not 0 <= args.faults <= 1:
        raise UserError(f"--faults must be a share from 0 to 1, got {args.faults}")
    model, sensor = sensor_model(args)
    program = existing_file(args.program, "program")
    motion, gauge_length_mm = played(program, args.gauge_length_mm)
    effects = Path(args.effects) if args.effects else None
    past = programs_before(args.after, model, gauge_length_mm, effects)
    plan = Plan(program, model, gauge_length_mm, args.seed, sensor, past=past, rest_s=args.rest_s)
    lines = list(plan.rig(motion.held(HOLD_S)).lines())
    port = PtyPort(args.link)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ctrl-C: the link must not stay behind
    try:
        print(port.name, flush=True)
        print(f"rig: the motion starts when the port is opened; {what_ends_it()} ends the rig", file=sys.stderr)
        unheard = serve(port, faulty(paced(lines, args.speed), args.faults, default_rng(args.seed)))
        if port.has_reader():
            port.wait_for_reader(wanted=False)
    finally:
        port.close()
    print(f"rig: the motion is over; {unheard} lines went unheard", file=sys.stderr)
    return 0
