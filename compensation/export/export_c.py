"""A compensator as one C header: no dependency, no heap, float32."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from compensation.engines.network import Network
from compensation.export.c_template import HEADER
from compensation.export.chip_cost import cost
from compensation.export.export_c_history import number, pieces
from compensation.memories.ema import log_retention, start_samples
from compensation.model.compensator import Fitted, TrainedCompensator, trained
from compensation.model.runtime import (
    LARGEST_CONDUCTANCE_S,
    LONGEST_STEP_S,
    SHORTEST_STEP_S,
    SMALLEST_CONDUCTANCE_S,
    Status,
    beginning_of,
    check_streams,
    limits_of,
    ranges_of,
)
from gcode.support.console import knitbench_version
from gcode.support.errors import UserError

# Of the target's standard deviation: what the header may differ from Python. Of the conductance's: so far beyond a
# range is still inside, for where the training stood at its end, as at a converter's rail, rounding would decide.
PROMISED = 1e-5


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
    compensator = trained(compensator)
    check_streams(compensator)
    needs, lengths = cost(compensator), start_samples(compensator.alphas, compensator.rate_hz)
    seen, begin, limits = ranges_of(compensator), beginning_of(compensator), limits_of(compensator)
    slack = PROMISED + rounding(compensator)
    filters = len(compensator.alphas)
    # The last layers take over the output's scale and the share in the mean.
    share = compensator.scaling_out.scale / len(compensator.networks)
    networks = [network.times(share) for network in compensator.networks]
    widest = max(max(network.sizes, default=1) for network in networks)
    tables = [_network_tables(name, index, network) for index, network in enumerate(networks)]
    calls = [_network_call(name, index, network) for index, network in enumerate(networks)]
    return HEADER.substitute(
        name=name,
        NAME=name.upper(),
        version=knitbench_version(),
        target=compensator.target,
        unit=compensator.unit,
        filters=filters,
        limits=_numbers(np.array(limits)),
        seen=_numbers(np.array([seen.low - slack, seen.high + slack])),
        inputs_low=_numbers(seen.inputs_low - slack),
        inputs_high=_numbers(seen.inputs_high + slack),
        begin_gain=_numbers(begin.gain[:filters]),
        begin_offset=_numbers(begin.offset[:filters]),
        flags=_flags(name.upper()),
        margins=_margins(name.upper(), compensator.margins),
        shortest=number(SHORTEST_STEP_S),
        longest=number(LONGEST_STEP_S),
        smallest=number(SMALLEST_CONDUCTANCE_S),
        largest=number(LARGEST_CONDUCTANCE_S),
        widest=widest,
        rate=number(compensator.rate_hz),
        mean=number(compensator.scaling_in.mean),
        inverse=number(1.0 / compensator.scaling_in.scale),
        alphas=_numbers(compensator.alphas),
        log_keep=_numbers(log_retention(compensator.alphas)),
        lengths=_numbers(lengths - 0.5),
        tables="\n".join(tables),
        calls="\n".join(calls),
        offset=number(compensator.scaling_out.mean),
        inputs=compensator.input_count,
        **vars(needs),
        **pieces(compensator, name),
    )


def _network_tables(name: str, index: int, network: Network) -> str:
    lines = []
    for layer, (weight, bias) in enumerate(zip(network.weights, network.biases, strict=True)):
        # Transposed: the weights of one unit lie side by side.
        lines.append(f"static const float {name}_w{index}_{layer}[{weight.size}] = {{{_numbers(weight.T.ravel())}}};")
        lines.append(f"static const float {name}_b{index}_{layer}[{bias.size}] = {{{_numbers(bias)}}};")
    return "\n".join(lines)


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


def _flags(prefix: str) -> str:
    comments = {
        Status.BAD_READING: "not finite or not positive: left out, the last value repeated",
        Status.BAD_STEP: "time step not finite, not positive or too long: left out likewise",
        Status.UNSEEN_READING: "conductance outside the range of the training",
        Status.UNSEEN_HISTORY: "a memory outside the range of the training",
        Status.STARTING: "the first samples",
    }
    return "\n".join(f"#define {prefix}_{flag.name} {int(flag)}u /* {text} */" for flag, text in comments.items())


def _margins(prefix: str, margins: tuple[float, float] | None) -> str:
    if margins is None:
        return ""
    low, high = map(number, margins)
    return (
        "/* Added to a value: the ends of the interval that holds 90 % of the errors to be expected. */\n"
        f"#define {prefix}_MARGIN_LOW ({low})\n#define {prefix}_MARGIN_HIGH ({high})\n"
    )


def _numbers(values: NDArray) -> str:
    return ", ".join(number(value) for value in values)
