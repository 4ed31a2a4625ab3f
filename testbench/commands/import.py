"""``testbench import``: a foreign file becomes a recording."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from testbench.commands._arguments import positive

if TYPE_CHECKING:
    from testbench.importing.wish import Wish

SUMMARY = "turn a file of a tester or logger (CSV, Excel, TDMS) into a recording (a campaign folder, or a .csv)"
EXAMPLE = """testbench import lab.csv --gauge-length-mm 40 -o lab
  testbench import raw.csv --time 3 --force 6 --force-unit N --time-unit s --displacement 4 --displacement-unit mm \\
      --gauge-length-mm 40 -o raw"""
# Keys of testbench.importing.vocabulary.roles.ROLES; that module is too heavy for --help.
COLUMNS = (
    ("time", "of the time"),
    ("displacement", ""),
    ("strain", "instead of a displacement"),
    ("force", ""),
    ("resistance", ""),
    ("conductance", "instead of a resistance"),
    ("relative-resistance", "R/R0 instead of a resistance"),
    ("relative-change", "(R-R0)/R0, or R-R0 in ohm, instead of a resistance"),
    ("temperature", ""),
)
UNITS = (
    ("time", "s, ms, us, ns, min, h, d, or date for dates and times"),
    ("displacement", "mm, um, cm, m, in"),
    ("strain", "1, %%, ‰, µε"),
    ("force", "N, mN, uN, cN, daN, kN, gf, kgf, lbf, ozf"),
    ("resistance", "ohm, mohm, kohm, Mohm, Gohm"),
    ("conductance", "S, mS, uS, nS"),
    ("temperature", "C, K, F"),
    ("relative", "1, %%, ‰, µε, of R-R0 ohm, kohm, ...; of a ratio such as R/R0 1 where nothing says another"),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="text (CSV and the like), .xlsx, .tdms, .parquet, JSON or HTML")
    parser.add_argument(
        "--gauge-length-mm", type=positive, metavar="L", help="length between the clamps at rest; needed for strain"
    )
    parser.add_argument(
        "-o", "--output", dest="out", required=True, metavar="OUT", help="campaign folder, or a file NAME.csv"
    )
    parser.add_argument("--overwrite", action="store_true", help="replace an earlier import, folder or file")
    parser.add_argument("--json", action="store_true", help="say what was taken for what as JSON")
    _add_columns(parser)
    _add_units(parser)
    _add_layout(parser)
    _add_repairs(parser)


def _add_columns(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group(
        "columns",
        "Found by name and unit. COL is a name, a number from 1, or none where there is no such column.",
    )
    shared = {name: group.add_mutually_exclusive_group() for name in ("time", "displacement", "resistance")}
    shared["strain"] = shared["displacement"]
    shared |= dict.fromkeys(("conductance", "relative-resistance", "relative-change"), shared["resistance"])
    for name, words in COLUMNS:
        shared.get(name, group).add_argument(f"--{name}", metavar="COL", help=words or None)
    shared["time"].add_argument(
        "--rate-hz", type=positive, metavar="F", help="sampling rate of a file without a time column"
    )
    group.add_argument(
        "--time-of",
        action="append",
        default=[],
        metavar="ROLE=COL",
        help="a channel's own time, where the file has several clocks: force=t_F; may be repeated",
    )
    group.add_argument(
        "--rest-ohm", "--r0-ohm", dest="r0_ohm", type=positive, metavar="R0", help="R0 of the relative ones"
    )
    group.add_argument("--repeat", metavar="N", help="of several repeats or specimens in the file, this one")


def _add_units(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("units", "Read from the header or a row of units; needed where they say none.")
    for name, words in UNITS:
        group.add_argument(f"--{name}-unit", metavar="UNIT", help=words)


def _add_layout(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("how the file is written", "All of this is found where the file shows it.")
    group.add_argument("--header-row", type=int, metavar="N", help="row of the names, from 1; 0: there is none")
    group.add_argument("--units-row", type=int, metavar="N", help="row of the units, from 1; 0: there is none")
    group.add_argument("--separator", metavar="CHAR", help="between columns; a blank stands for any number of them")
    group.add_argument("--decimal", choices=[".", ","])
    group.add_argument("--thousands", metavar="CHAR", help="between groups of three digits")
    group.add_argument("--encoding", metavar="NAME", help="such as utf-8, latin-1, gbk")
    group.add_argument("--sheet", metavar="NAME", help="sheet of a workbook, group of a TDMS file")


def _add_repairs(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("repairs")
    group.add_argument(
        "--negate",
        nargs="+",
        default=[],
        metavar="ROLE",
        help="turn the sign of displacement, strain, force, resistance, conductance",
    )
    group.add_argument(
        "--zero",
        nargs="+",
        default=[],
        metavar="ROLE[=VALUE]",
        help="count displacement or force from its first sample, or from a value in the file's unit",
    )
    group.add_argument("--sort", action="store_true", help="put rows in the order of time, drop repeated times")
    group.add_argument("--drop-bad", action="store_true", help="leave out rows with values that cannot be used")


def run(args: argparse.Namespace) -> int:
    import json

    from testbench.api.files.importing import imported

    found = imported(args.file, wish_of(args))
    found.write(args.out, args.overwrite)
    print(json.dumps(found.to_dict(args.out)) if args.json else found.words(args.out))
    return 0


def wish_of(args: argparse.Namespace) -> Wish:
    """What the command line says about the file."""
    from testbench.importing.sheet import Hints
    from testbench.importing.wish import Wish

    columns = {name.replace("-", "_"): getattr(args, name.replace("-", "_")) for name, _ in COLUMNS}
    columns["relative"] = columns.pop("relative_resistance")
    units = {name: getattr(args, f"{name}_unit") for name, _ in UNITS}
    units["relative_change"] = units["relative"]
    zero = dict(part.partition("=")[::2] for part in args.zero)
    return Wish(
        gauge_length_mm=args.gauge_length_mm,
        columns={role: column for role, column in columns.items() if column is not None},
        units={role: unit for role, unit in units.items() if unit is not None},
        rate_hz=args.rate_hz,
        time_of=_time_of(args.time_of),
        r0_ohm=args.r0_ohm,
        negate=frozenset(args.negate),
        zero={role: value or None for role, value in zero.items()},
        repeat=args.repeat,
        sort=args.sort,
        drop_bad=args.drop_bad,
        hints=Hints(
            separator=args.separator and args.separator.replace("\\t", "\t"),
            decimal=args.decimal,
            thousands=args.thousands,
            encoding=args.encoding,
            sheet=args.sheet,
            header_row=args.header_row,
            units_row=args.units_row,
        ),
    )


def _time_of(given: list[str]) -> dict[str, str]:
    from gcode.support.errors import UserError
    from testbench.importing.choice import FLAGS

    role_of = {flag.removeprefix("--"): role for role, flag in FLAGS.items()}
    for part in given:
        role, sign, column = part.partition("=")
        if not sign or not column or role not in [name for name, _ in COLUMNS]:
            raise UserError(f"--time-of must be ROLE=COL such as force=t_F, got {part!r}")
    clocks = dict(part.partition("=")[::2] for part in given)
    return {role_of[name]: column for name, column in clocks.items()}
