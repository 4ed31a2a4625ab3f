"""``testbench import``: a foreign CSV becomes a recording."""

from __future__ import annotations

import argparse
from pathlib import Path

SUMMARY = "turn a foreign CSV into a recording (a campaign folder, or a .csv)"
EXAMPLE = (
    "testbench import lab.csv --time t --displacement x --force F --resistance R --resistance-unit kohm "
    "--gauge-length-mm 40 -o lab"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    from testbench.sensors import positive

    parser.add_argument("file", metavar="FILE", help="CSV; separator, decimal comma and header line are found")
    when = parser.add_mutually_exclusive_group(required=True)
    when.add_argument("--time", metavar="COL", help="column of the time")
    when.add_argument("--rate-hz", type=positive, metavar="F", help="sampling rate of a file without a time column")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--displacement", metavar="COL")
    where.add_argument("--strain", metavar="COL", help="instead of a displacement")
    parser.add_argument("--force", metavar="COL")
    electrical = parser.add_mutually_exclusive_group()
    electrical.add_argument("--resistance", metavar="COL")
    electrical.add_argument("--conductance", metavar="COL", help="instead of a resistance")
    electrical.add_argument("--relative-resistance", metavar="COL", help="R/R0 instead of a resistance")
    electrical.add_argument("--relative-change", metavar="COL", help="(R-R0)/R0 instead of a resistance")
    parser.add_argument(
        "--r0-ohm", type=positive, default=1.0, metavar="R0", help="for the relative ones (default 1)"
    )
    parser.add_argument("--temperature", metavar="COL", help="in degrees Celsius")
    parser.add_argument("--gauge-length-mm", type=positive, required=True, metavar="L")
    _add_units(parser)
    parser.add_argument("--separator", metavar="CHAR", help="default: found in the file")
    parser.add_argument("--decimal", choices=[".", ","], help="default: found in the file")
    parser.add_argument("--sort", action="store_true", help="put rows in the order of time, drop repeated times")
    parser.add_argument("--drop-bad", action="store_true", help="leave out rows with values that cannot be used")
    parser.add_argument("--overwrite", action="store_true", help="replace an earlier import in that folder")
    parser.add_argument("-o", dest="out", required=True, metavar="OUT", help="campaign folder, or a file NAME.csv")


def _add_units(parser: argparse.ArgumentParser) -> None:
    # The keys of the tables in testbench.importing; that module is too heavy for --help.
    parser.add_argument("--time-unit", choices=["s", "ms", "us", "min", "h", "date"], default="s")
    parser.add_argument("--displacement-unit", choices=["mm", "um", "cm", "m", "in"], default="mm")
    parser.add_argument("--strain-unit", choices=["1", "%"], default="1")
    parser.add_argument("--force-unit", choices=["N", "mN", "cN", "kN", "gf", "kgf", "lbf"], default="N")
    parser.add_argument("--resistance-unit", choices=["ohm", "mohm", "kohm", "Mohm"], default="ohm")
    parser.add_argument("--conductance-unit", choices=["S", "mS", "uS", "nS"], default="S")


def run(args: argparse.Namespace) -> int:
    from testbench.campaign import vacant
    from testbench.importing import import_csv, write_import
    from testbench.sensors import existing_file

    path, out = existing_file(args.file, "CSV"), Path(args.out)
    imported = import_csv(path, wish_of(args))
    if out.suffix.lower() != ".csv":
        vacant(out, args.overwrite)
    write_import(imported, out)
    recording = imported.recording
    done = [
        f"{number} row{'s' if number > 1 else ''} {what}"
        for number, what in (
            (imported.dropped, "left out"),
            (imported.moved, "put in order"),
            (imported.repeated, "with a repeated time dropped"),
        )
        if number
    ]
    names = ", ".join(recording.channels)
    print(
        f"{out}: {len(recording)} samples in {recording.duration_s:.1f} s, {recording.mean_rate_hz:.1f} Hz: {names}"
    )
    if done:
        print(f"{out}: {', '.join(done)}")
    return 0


def wish_of(args: argparse.Namespace):
    """What the command line says about the file."""
    from testbench import importing as units

    def source(column: str | None, factor: float = 1.0):
        return None if column is None else units.Source(column, factor)

    return units.Wish(
        gauge_length_mm=args.gauge_length_mm,
        time=source(args.time, units.TIME_UNITS.get(args.time_unit, 1.0)),
        time_is_date=args.time_unit == "date",
        rate_hz=args.rate_hz,
        displacement=source(args.displacement, units.LENGTH_UNITS[args.displacement_unit]),
        strain=source(args.strain, units.STRAIN_UNITS[args.strain_unit]),
        force=source(args.force, units.FORCE_UNITS[args.force_unit]),
        resistance=source(args.resistance, units.RESISTANCE_UNITS[args.resistance_unit]),
        conductance=source(args.conductance, units.CONDUCTANCE_UNITS[args.conductance_unit]),
        relative=source(args.relative_resistance),
        relative_change=source(args.relative_change),
        temperature=source(args.temperature),
        r0_ohm=args.r0_ohm,
        sort=args.sort,
        drop_bad=args.drop_bad,
        separator=args.separator.replace("\\t", "\t") if args.separator else None,
        decimal=args.decimal,
    )
