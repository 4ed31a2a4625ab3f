"""A compensator as one C header: no dependency, no heap, float32."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from compensation.engines.network import Network
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

# Of the target's standard deviation: what the header may differ from Python.
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
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        raise UserError(f"--name must be a C identifier, got {name!r}")
    compensator = trained(compensator)
    check_streams(compensator)
    needs, lengths = cost(compensator), start_samples(compensator.alphas, compensator.rate_hz)
    seen, begin, limits = ranges_of(compensator), beginning_of(compensator), limits_of(compensator)
    filters = len(compensator.alphas)
    # The last layers take over the output's scale and the share in the mean.
    share = compensator.scaling_out.scale / len(compensator.networks)
    networks = [network.times(share) for network in compensator.networks]
    widest = max(max(network.sizes, default=1) for network in networks)
    tables = [_network_tables(name, index, network) for index, network in enumerate(networks)]
    calls = [_network_call(name, index, network) for index, network in enumerate(networks)]
    return TEMPLATE.format(
        name=name,
        NAME=name.upper(),
        version=knitbench_version(),
        target=compensator.target,
        unit=compensator.unit,
        filters=filters,
        limits=_numbers(np.array(limits)),
        seen=_numbers(np.array([seen.low, seen.high])),
        inputs_low=_numbers(seen.inputs_low),
        inputs_high=_numbers(seen.inputs_high),
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
        needs=needs,
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


TEMPLATE = """\
/* Compensator for {target} ({unit}), written by knitbench {version}. Do not edit: export it again.
 *
 *   {name}_state s;
 *   {name}_reset(&s);
 *   float p = {name}_update(&s, conductance_S, dt_s);   // each sample; dt_s: seconds since the last good one
 *   if (s.status != 0u) ...                              // see the flags below
 *
 * A reading that is not finite or not positive, or a bad dt_s, leaves everything as it was and gives the last value
 * again. No heap, no library.
 * Constants {needs.constants_bytes} bytes of flash, state {needs.state_bytes} bytes of RAM,
 * {needs.scratch_bytes} bytes of stack for values, {needs.multiplies} multiplications a sample of the nominal step,
 * {needs.multiplies_any_step} of any other.
 */
#ifndef {NAME}_COMPENSATOR_H
#define {NAME}_COMPENSATOR_H

#include <stdint.h>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "compile without -ffast-math: faulty readings are recognised by the rules of IEEE 754"
#endif

{flags}

#define {NAME}_FILTERS {filters}u
#define {NAME}_INPUTS {inputs}u
#define {NAME}_WIDEST {widest}u
#define {NAME}_RATE_HZ {rate}
{margins}
typedef struct {{
    float forced[{NAME}_FILTERS]; /* response from a zero state */
    float lost[{NAME}_FILTERS];   /* what rounding has taken from it so far */
    float fading[{NAME}_FILTERS]; /* what is left of the initial value */
    float start[{NAME}_FILTERS];  /* the initial value: mean of the first samples */
    float elapsed;                /* in steps of 1/rate, until every start is known */
    float value;                  /* the last prediction */
    uint32_t seen;                /* samples so far, as long as a start is not known */
    uint32_t status;              /* flags of the last sample; 0: good */
{history_state}}} {name}_state;

static const float {name}_alpha[{filters}] = {{{alphas}}};
static const float {name}_log_keep[{filters}] = {{{log_keep}}};
static const float {name}_start_steps[{filters}] = {{{lengths}}};
static const float {name}_begin_gain[{filters}] = {{{begin_gain}}};
static const float {name}_begin_offset[{filters}] = {{{begin_offset}}};
static const float {name}_limits[2] = {{{limits}}};
static const float {name}_seen[2] = {{{seen}}};
static const float {name}_inputs_low[{inputs}] = {{{inputs_low}}};
static const float {name}_inputs_high[{inputs}] = {{{inputs_high}}};
{history_tables}{tables}

static inline void {name}_reset({name}_state *s) {{
    for (uint32_t i = 0u; i < {NAME}_FILTERS; i++) {{
        s->forced[i] = 0.0f;
        s->lost[i] = 0.0f;
        s->fading[i] = 1.0f;
        s->start[i] = 0.0f;
    }}
    s->elapsed = 0.0f;
    s->value = {offset};
    s->seen = 0u;
    s->status = {NAME}_STARTING;
{history_reset}}}

/* 1 - exp(x) for x <= 0, accurate near zero: a series after halving, then squared up again. */
static inline float {name}_gain(float x) {{
    uint32_t halvings = 0u;
    float y = x;
    if (x < -16.0f) {{
        y = -1.0f;
    }} else {{
        while (y < -0.5f) {{
            y *= 0.5f;
            halvings++;
        }}
        y = y * (1.0f + (y * (0.5f + (y * (1.6666667e-1f + (y * (4.1666667e-2f + (y * (8.3333333e-3f +
            (y * 1.3888889e-3f))))))))));
        for (; halvings > 0u; halvings--) {{
            y *= y + 2.0f;
        }}
    }}
    return -y;
}}

static inline void {name}_layer(const float *in, uint32_t n_in, float *out, uint32_t n_out, const float *w,
                                const float *b, uint32_t relu) {{
    for (uint32_t j = 0u; j < n_out; j++) {{
        float sum = b[j];
        for (uint32_t i = 0u; i < n_in; i++) {{
            sum += w[(j * n_in) + i] * in[i];
        }}
        out[j] = ((relu != 0u) && (sum < 0.0f)) ? 0.0f : sum;
    }}
}}

/* What is wrong with a sample itself; comparisons with a NaN are false. */
static inline uint32_t {name}_fault(float conductance_S, float dt_s) {{
    uint32_t fault = 0u;
    if (!((conductance_S >= {smallest}) && (conductance_S <= {largest}))) {{
        fault |= {NAME}_BAD_READING;
    }}
    if (!((dt_s >= {shortest}) && (dt_s <= {longest}))) {{
        fault |= {NAME}_BAD_STEP;
    }}
    return fault;
}}

/* Take one good sample into all memories, in standard deviations; the networks' inputs. */
static inline void {name}_remember({name}_state *s, float x, float dt_s, float *features) {{
    const uint32_t first = (s->seen == 0u) ? 1u : 0u;
    const float steps = (first != 0u) ? 0.0f : (dt_s * {NAME}_RATE_HZ);
    const uint32_t nominal = ((steps > 0.999999f) && (steps < 1.000001f)) ? 1u : 0u;
    uint32_t starting = first;
    if (first == 0u) {{
        s->elapsed += steps;
    }}
    for (uint32_t i = 0u; i < {NAME}_FILTERS; i++) {{
        starting |= (s->elapsed < {name}_start_steps[i]) ? 1u : 0u;
    }}
    if (starting != 0u) {{
        s->seen++;
        s->status |= {NAME}_STARTING;
    }} else {{
        s->elapsed = {name}_start_steps[{NAME}_FILTERS - 1u] + 1.0e6f; /* no filter starts any more */
    }}
    for (uint32_t i = 0u; i < {NAME}_FILTERS; i++) {{
        const float gain = (nominal != 0u) ? {name}_alpha[i] : {name}_gain({name}_log_keep[i] * steps);
        /* Kahan's sum: a slow filter takes steps that a float would lose. */
        const float step = (gain * (x - s->forced[i])) - s->lost[i];
        const float next = s->forced[i] + step;
        s->lost[i] = (next - s->forced[i]) - step;
        s->forced[i] = next;
        s->fading[i] = (s->fading[i] < 1.0e-12f) ? 0.0f : (s->fading[i] - (gain * s->fading[i]));
        if ((first != 0u) || (s->elapsed < {name}_start_steps[i])) {{
            s->start[i] += (x - s->start[i]) / (float)s->seen;
        }}
        features[i] = s->forced[i] + (s->fading[i] * ({name}_begin_offset[i] + ({name}_begin_gain[i] * s->start[i])));
    }}
{history_update}}}

/* Feed one sample: conductance in S, seconds since the last good one (ignored for the first). Returns {unit}. */
static inline float {name}_update({name}_state *s, float conductance_S, float dt_s) {{
    const float step_s = (s->seen == 0u) ? (1.0f / {NAME}_RATE_HZ) : dt_s;
    s->status = {name}_fault(conductance_S, step_s);
    if (s->status == 0u) {{
        float features[{NAME}_INPUTS], even[{NAME}_WIDEST], odd[{NAME}_WIDEST], value, result = {offset};
        const float reading = (conductance_S - {mean}) * {inverse};
        const float raised = (reading < {name}_limits[0]) ? {name}_limits[0] : reading;
        {name}_remember(s, (raised > {name}_limits[1]) ? {name}_limits[1] : raised, dt_s, features);
        if ((reading < {name}_seen[0]) || (reading > {name}_seen[1])) {{
            s->status |= {NAME}_UNSEEN_READING;
        }}
        for (uint32_t i = 0u; i < {NAME}_INPUTS; i++) {{
            if ((features[i] < {name}_inputs_low[i]) || (features[i] > {name}_inputs_high[i])) {{
                s->status |= {NAME}_UNSEEN_HISTORY;
            }}
        }}
        (void)even;
        (void)odd;
{calls}
        s->value = result;
    }}
    return s->value;
}}

#endif
"""
