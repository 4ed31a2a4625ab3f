"""A compensator as one C header (no dependency, no heap, float32), and what it needs on a chip."""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from compensation.engines.network import Network
from compensation.export.c_template import HEADER
from compensation.memories.ema import log_retention, start_steps
from compensation.model.compensator import Fitted, TrainedCompensator
from compensation.model.runtime import MEANING, READINGS_S, STEPS_S, limits_of, ranges_of, streamable
from gcode.support.arrays import FloatArray
from gcode.support.console import knitbench_version
from gcode.support.errors import UserError

# Of the target's standard deviation: what the header may differ from Python. Of the conductance's: so far beyond a
# range is still inside, for where the training stood at its end, as at a converter's rail, rounding would decide.
PROMISED = 1e-5
# Of the header's exponential: terms of the series, and up to which exponent it is taken.
SERIES, LARGEST_EXPONENT = 6, 0.5


def rounding(compensator: TrainedCompensator) -> float:
    """Error of a conductance in single precision, in standard deviations of the training.

    Where it is above `PROMISED`, the header's value is about as far off: no arithmetic brings back what was not read.
    """
    scaling = compensator.scaling_in
    return float(np.finfo(np.float32).eps) / 2 * abs(scaling.mean) / scaling.scale


def c_header(compensator: TrainedCompensator | Fitted, name: str = "knitbench") -> str:
    """Write a compensator as one C99 header, to be fed sample by sample; it needs no library and no heap.

    Parameters
    ----------
    compensator : TrainedCompensator or Compensator
        As loaded, or fitted. Its scaling of the output, and the mean over its networks, are folded into their last
        layers.
    name : str
        Prefix of every C name.

    Returns
    -------
    str
        The header's text. ``float NAME_update(NAME_state *s, float conductance_S, float dt_s)`` takes a conductance
        in S and the seconds since the last good sample, and returns the force in N or the displacement in mm, in
        single precision. ``s->status`` has the flags of `compensation.model.runtime.Status`; 0 is good.

    Raises
    ------
    UserError
        If `name` is no C identifier, or the compensator standardises each recording by itself, which needs all of it.

    Examples
    --------
    >>> import testbench as tb
    >>> from compensation import Compensator, c_header
    >>> recording = tb.example(duration_s=60).resampled(20.0)
    >>> model = Compensator(method="paper").fit(recording.conductance_S[:, None], recording["force_N"])
    >>> header = c_header(model, "knit")
    >>> "float knit_update(knit_state *s, float conductance_S, float dt_s)" in header
    True
    """
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", str(name)):
        raise UserError(f"`name` must be a C identifier, got {name!r}")
    compensator = streamable(compensator)
    # The last layers take over the output's scale and the share in the mean.
    share = compensator.scaling_out.scale / len(compensator.networks)
    networks = [network.times(share) for network in compensator.networks]
    history, rate_hz = compensator.history, compensator.rate_hz
    return HEADER.substitute(
        name=name,
        NAME=name.upper(),
        version=knitbench_version(),
        target=compensator.target,
        unit=compensator.unit,
        filters=len(compensator.alphas),
        inputs=compensator.input_count,
        widest=max(max(network.sizes, default=1) for network in networks),
        motions=len(history.motion_taus_s),
        plays=len(history.play_radii),
        flags="\n".join(
            f"#define {name.upper()}_{flag.name} {int(flag)}u /* {text} */" for flag, text in MEANING.items()
        ),
        margins=_margins(name.upper(), compensator.margins),
        shortest=_number(STEPS_S[0]),
        longest=_number(STEPS_S[1]),
        smallest=_number(READINGS_S[0]),
        largest=_number(READINGS_S[1]),
        rate=_number(rate_hz),
        mean=_number(compensator.scaling_in.mean),
        inverse=_number(1.0 / compensator.scaling_in.scale),
        offset=_number(compensator.scaling_out.mean),
        per_settle=_number(-1.0 / history.settle_s),
        settle_gain=_number(-np.expm1(-1.0 / (rate_hz * history.settle_s))),
        tables="\n".join(_table(f"{name}_{what}", values) for what, values in _tables(compensator, networks)),
        calls="\n".join(_network_call(name, index, network) for index, network in enumerate(networks)),
        **vars(cost(compensator)),
    )


def _tables(compensator: TrainedCompensator, networks: Sequence[Network]) -> Iterator[tuple[str, FloatArray]]:
    """Name and numbers of every array of constants that is used."""
    seen, begin, history = ranges_of(compensator), compensator.begins, compensator.history
    slack = PROMISED + rounding(compensator)
    yield "limits", np.array(limits_of(compensator))
    yield "seen", np.array([seen.low - slack, seen.high + slack])
    yield "inputs_low", seen.inputs_low - slack
    yield "inputs_high", seen.inputs_high + slack
    yield "alpha", compensator.alphas
    yield "log_keep", log_retention(compensator.alphas)
    yield "start_steps", start_steps(compensator.alphas, compensator.rate_hz)
    ends = np.cumsum([len(compensator.alphas), len(history.motion_taus_s)])
    kinds = ("", "motion_", "play_")
    for kind, gain, offset in zip(kinds, np.split(begin.gain, ends), np.split(begin.offset, ends), strict=True):
        if len(gain):
            yield f"{kind}begin_gain", gain
            yield f"{kind}begin_offset", offset
    if history.motion_taus_s:
        per_s = -1.0 / np.asarray(history.motion_taus_s)
        yield "per_s", per_s
        yield "motion_gain", -np.expm1(per_s / compensator.rate_hz)
    if history.play_radii:
        yield "play_radius", np.asarray(history.play_radii)
    for index, network in enumerate(networks):
        for layer, (weight, bias) in enumerate(zip(network.weights, network.biases, strict=True)):
            yield f"w{index}_{layer}", weight.T.ravel()  # the weights of one unit lie side by side
            yield f"b{index}_{layer}", bias


def _table(name: str, values: FloatArray) -> str:
    return f"static const float {name}[{len(values)}] = {{{', '.join(map(_number, values))}}};"


def _number(value: float) -> str:
    """A float constant of C, as its float32 is written."""
    return f"{float(np.float32(value))!r}f"


def _network_call(name: str, index: int, network: Network) -> str:
    lines, source = [], "features"
    for layer, weight in enumerate(network.weights):
        last = layer == len(network.weights) - 1
        out = "&value" if last else ("even" if layer % 2 == 0 else "odd")
        lines.append(
            f"        {name}_layer({source}, {weight.shape[0]}u, {out}, {weight.shape[1]}u, "
            f"{name}_w{index}_{layer}, {name}_b{index}_{layer}, {int(not last)}u);"
        )
        source = out
    return "\n".join([*lines, "        result += value;"])


def _margins(prefix: str, margins: tuple[float, float] | None) -> str:
    if margins is None:
        return ""
    low, high = map(_number, margins)
    return (
        "/* Added to a value: the ends of the interval that holds 90 % of the errors to be expected. */\n"
        f"#define {prefix}_MARGIN_LOW ({low})\n#define {prefix}_MARGIN_HIGH ({high})\n"
    )


@dataclass(frozen=True)
class Cost:
    """What a compensator needs on a chip."""

    constants_bytes: int  # flash: weights, biases and filter constants
    state_bytes: int  # RAM kept between samples
    scratch_bytes: int  # stack used while a sample is worked on (layer values)
    multiplies: int  # a sample at the nominal step
    # The same at a step that is not nominal to a millionth, as a clock gives: every filter's gain is made anew.
    multiplies_any_step: int


def cost(compensator: TrainedCompensator) -> Cost:
    filters, history = len(compensator.alphas), compensator.history
    motions, plays, remembers = len(history.motion_taus_s), len(history.play_radii), int(history.count > 0)
    weights = sum(matrix.size for network in compensator.networks for matrix in network.weights)
    widest = max(max(network.sizes, default=1) for network in compensator.networks)
    constants = compensator.parameter_count + 5 * filters + 2 * compensator.input_count + 4
    nominal = weights + 4 * filters + 1 + 2 * motions + plays + 2 * remembers
    return Cost(
        constants_bytes=4 * (constants + 4 * motions + 3 * plays + remembers),
        state_bytes=4 * (4 * filters + 4 + history.count + 2 * remembers),
        scratch_bytes=4 * (compensator.input_count + 2 * widest),
        multiplies=nominal,
        multiplies_any_step=nominal + _gains(compensator),
    )


def _gains(compensator: TrainedCompensator) -> int:
    """Multiplications of `NAME_gain` for all filters, 1 % late: the exponent, the series, two for each halving."""
    late, history = 1.01, compensator.history
    taus_s = np.array([history.settle_s, *history.motion_taus_s] if history.count else [])
    exponents = late * np.concatenate([-log_retention(compensator.alphas), 1.0 / (compensator.rate_hz * taus_s)])
    halvings = np.ceil(np.log2(np.maximum(exponents / LARGEST_EXPONENT, 1.0)))
    return int(np.sum(1 + SERIES + 2 * halvings))


def code_bytes(header: str, name: str) -> int | None:
    """Machine code of ``update`` and ``reset`` as this machine's gcc makes it (-Os); None without such a compiler."""
    caller = (
        f'#include "h.h"\nfloat u({name}_state *s, float g, float t) {{ return {name}_update(s, g, t); }}\n'
        f"void r({name}_state *s) {{ {name}_reset(s); }}\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "h.h").write_text(header)
        Path(folder, "u.c").write_text(caller)
        try:
            subprocess.run(["gcc", "-Os", "-c", "u.c", "-o", "u.o"], cwd=folder, check=True, capture_output=True)
            sized = subprocess.run(["size", "-A", "u.o"], cwd=folder, check=True, capture_output=True, text=True)
        except (OSError, subprocess.CalledProcessError):  # no such tools, or others of these names
            return None
    rows = (line.split() for line in sized.stdout.splitlines())
    return sum(int(row[1]) for row in rows if row and row[0].startswith(".text"))
