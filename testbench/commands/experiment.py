"""``testbench experiment``: the next trajectory, chosen to separate rival hypotheses."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from testbench.commands._arguments import add_effects, add_held_out, load_recording, load_split
from testbench.commands._telling import Telling

if TYPE_CHECKING:
    from collections.abc import Sequence

    from testbench.design.experiment import Option, Rival
    from testbench.knit.effect import FloatArray

SUMMARY = "propose the next trajectory: the one that separates two rival models best"
EXAMPLE = "testbench experiment creep.json relaxation.json --strain-max 30 -o next-run --plot next-run.png"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("models", nargs="*", metavar="MODEL", help="two or more rival model.json")
    parser.add_argument("--diagnosis", metavar="JSON", help="instead: the tied effects of this diagnosis ...")
    parser.add_argument("--fit", metavar="RECORDING", help="... each put in and refitted on this recording")
    add_held_out(parser)
    add_effects(parser)
    parser.add_argument("--v-max", type=float, default=10.0, metavar="MM/S", help="speed limit (default: 10)")
    parser.add_argument("--a-max", type=float, default=20.0, metavar="MM/S2", help="acceleration limit (default: 20)")
    parser.add_argument("--strain-max", type=float, default=30.0, metavar="%", help="largest strain (default: 30)")
    parser.add_argument("--duration-s", type=float, default=600.0, metavar="S", help="length (default: 600)")
    parser.add_argument("--seed", type=int, default=1, help="of the random protocols (default: 1)")
    parser.add_argument("--temperature", action="store_true", help="the temperature will be measured too")
    parser.add_argument("-o", "--output", metavar="DIR", help="write the best one's program and trajectory here")
    parser.add_argument("--plot", metavar="FILE.png", help="draw the best one and what it would show")
    parser.add_argument("--json", metavar="OUT", help="write the whole ranking here")


def run(args: argparse.Namespace) -> int:
    """Weigh the protocols, print the ranking, write the winner."""
    from gcode.support.files import write_json
    from testbench.design.experiment import propose
    from testbench.design.experiment_words import experiment_table
    from testbench.design.protocols import Bounds, menu

    rivals, noise, gauge_length_mm, temperature = _rivals(args)
    bounds = Bounds(args.v_max, args.a_max, args.strain_max, args.duration_s, gauge_length_mm)
    tell = Telling("motion", len(menu(bounds)), "imitating on")
    options = propose(rivals, noise, bounds, args.seed, temperature, tell)
    Telling()("")
    print(experiment_table(rivals, options))
    if args.json:
        write_json(args.json, _as_json(rivals, options, gauge_length_mm))
    if args.plot:
        _draw(options, gauge_length_mm, args.plot)
    if args.output:
        for path in options[0].made.write(args.output):
            print(path)
    return 0


def _draw(options: list[Option], gauge_length_mm: float, path: str) -> None:
    from testbench.report.experiment_figures import experiment
    from testbench.report.static import write_figure

    made = options[0].made.trajectory
    strain = 100 * made.position_mm / gauge_length_mm
    evidence = [(option.name, option.hardest.log_odds) for option in options]
    write_figure(experiment(evidence, made.time_s, strain, _left(options[0])), path)
    print(f"picture: {path}")


def _left(option: Option) -> dict[str, tuple[FloatArray, FloatArray]]:
    """What the wrong model cannot imitate, by channel: time and misfit over the noise floor, from the burn-in on."""
    time_s = option.made.trajectory.time_s
    return {channel: (time_s[-len(values) :], values) for channel, values in option.hardest.left.items()}


def _as_json(rivals: Sequence[Rival], options: Sequence[Option], gauge_length_mm: float) -> dict[str, Any]:
    """The ranking, and what the winner would show, thinned to what a screen can draw."""
    from testbench.report.downsample import rows_to_draw

    left = {}
    for channel, (time_s, values) in _left(options[0]).items():
        rows = rows_to_draw(values)
        left[channel] = {"time_s": time_s[rows].round(3).tolist(), "over_noise": values[rows].round(4).tolist()}
    return {
        "rivals": [rival.name for rival in rivals],
        "gauge_length_mm": gauge_length_mm,
        "options": [option.to_dict() for option in options],
        "left": left,
    }


def _rivals(args: argparse.Namespace):
    """Rivals, noise floors, gauge length and whether the temperature is measured."""
    from gcode.support.errors import UserError
    from testbench.design.rivals import rivals_from_diagnosis, rivals_from_files
    from testbench.knit.catalogue import load_catalogue
    from testbench.recordings.recording import TEMPERATURE

    catalogue = load_catalogue(args.effects)
    if args.diagnosis:
        if args.models or not args.fit:
            raise UserError("experiment: --diagnosis goes with --fit RECORDING and without MODEL files")
        recording = load_recording(args.fit, args.gauge_length_mm)
        calibration, held = load_split(args, args.fit)
        rivals, noise = rivals_from_diagnosis(args.diagnosis, calibration, held, catalogue, Telling())
        return rivals, noise, recording.gauge_length_mm, args.temperature or recording.has(TEMPERATURE)
    if len(args.models) < 2:
        raise UserError("experiment: give two rival MODEL files, or --diagnosis JSON --fit RECORDING")
    rivals, noise, gauge_length_mm = rivals_from_files(args.models, catalogue)
    return rivals, noise, args.gauge_length_mm or gauge_length_mm, args.temperature
