"""``compensation export``: put a compensator on a chip or into another program."""

from __future__ import annotations

import argparse
from pathlib import Path

from compensation.commands.common import check_places
from gcode.support.errors import UserError

SUMMARY = "write a compensator as a C header for a chip, or as an ONNX model"
ENDINGS = {".h": "c", ".c": "c", ".hpp": "c", ".onnx": "onnx"}
EXAMPLE = "compensation export pes.compensator.json --format c -o pes.h --name pes"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("compensator", metavar="COMPENSATOR", help="file written by `compensation train`")
    parser.add_argument(
        "--format", choices=("c", "onnx"), help="c: one header; default: as FILE ends, c where that says nothing"
    )
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="file to write")
    parser.add_argument("--name", default="knitbench", help="prefix of the C names (default knitbench)")


def run(args: argparse.Namespace) -> int:
    from compensation.export.export_c import PROMISED, c_header, code_bytes, cost, rounding
    from compensation.model.files import load
    from gcode.support.files import write_text

    check_places(args.output, None)
    chosen = _format(args.format, args.output)
    compensator = load(args.compensator)
    if chosen == "onnx":
        from compensation.export.export_onnx import write_onnx

        write_onnx(compensator, args.output)
        print(
            f"wrote {args.output}: one step; feed it {compensator.rate_hz:g} x dt as `steps` (0 for the first sample)"
        )
        return 0
    header = c_header(compensator, args.name)
    write_text(args.output, header)
    needs, code = cost(compensator), code_bytes(header, args.name)
    shown = f"{code} bytes of code by this machine's gcc -Os" if code else "code size unknown: no gcc here"
    print(f"wrote {args.output}: flash {needs.constants_bytes} bytes of constants + {shown}")
    print(
        f"RAM {needs.state_bytes} bytes, {needs.scratch_bytes} of stack; {needs.multiplies} multiplies a sample, "
        f"{needs.multiplies_any_step} where dt is not exactly {1 / compensator.rate_hz:g} s"
    )
    if rounding(compensator) > PROMISED:
        print(
            f"warning: the conductance moves by little of its mean, so that single precision is off by "
            f"{rounding(compensator):.1g} of its standard deviation; values may differ from Python's by as much"
        )
    return 0


def _format(said: str | None, output: str) -> str:
    """What to write; an ending of the other format is refused, since other programs go by it."""
    ending = Path(output).suffix.lower()
    ends = ENDINGS.get(ending, said or "c")
    if said and said != ends:
        raise UserError(f"{output}: ends in {ending}, which is not --format {said}; choose another name with -o")
    return ends
