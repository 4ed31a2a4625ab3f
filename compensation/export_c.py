"""A compensator as one C header: no dependency, no heap, float32."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from compensation.compensator import Compensator
from compensation.ema import start_samples
from compensation.export_c_history import constants_bytes, multiplies, pieces, state_bytes
from compensation.network import Network
from gcode.support.console import knitbench_version
from gcode.support.errors import UserError


@dataclass(frozen=True)
class Cost:
    """What a compensator needs on a chip.

    Attributes
    ----------
    constants_bytes : int
        Weights, biases and filter constants, in flash.
    state_bytes : int
        RAM kept between samples.
    scratch_bytes : int
        Stack used while a sample is worked on (layer values).
    multiplies : int
        Multiplications a sample at the nominal rate.
    """

    constants_bytes: int
    state_bytes: int
    scratch_bytes: int
    multiplies: int


def cost(compensator: Compensator) -> Cost:
    """Count bytes and multiplications."""
    filters = len(compensator.alphas)
    weights = sum(matrix.size for network in compensator.networks for matrix in network.weights)
    widest = max(max(network.sizes, default=1) for network in compensator.networks)
    return Cost(
        constants_bytes=4 * (compensator.parameter_count + 3 * filters) + constants_bytes(compensator.history),
        state_bytes=4 * (3 * filters + 2) + state_bytes(compensator.history),
        scratch_bytes=4 * (compensator.input_count + 2 * widest),
        multiplies=weights + 3 * filters + 1 + multiplies(compensator.history),
    )


def c_header(compensator: Compensator, name: str = "knitbench") -> str:
    """The header's text.

    Parameters
    ----------
    compensator : Compensator
        The output's scaling is folded into the last layer, the mean over several networks too.
    name : str
        Prefix of every C name.

    Raises
    ------
    UserError
        If `name` is no C identifier, or the compensator needs a whole recording at once.
    """
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        raise UserError(f"--name must be a C identifier, got {name!r}")
    if compensator.per_recording:
        raise UserError("a compensator trained with --per-recording needs the whole recording; train without it")
    needs, lengths = cost(compensator), start_samples(compensator.alphas, compensator.rate_hz)
    log_keep = np.log1p(-np.minimum(compensator.alphas, 1 - 1e-16))
    networks = [_folded(network, compensator) for network in compensator.networks]
    widest = max(max(network.sizes, default=1) for network in networks)
    tables = [_network_tables(name, index, network) for index, network in enumerate(networks)]
    calls = [_network_call(name, index, network) for index, network in enumerate(networks)]
    return TEMPLATE.format(
        name=name,
        NAME=name.upper(),
        version=knitbench_version(),
        target=compensator.target,
        unit=compensator.unit,
        filters=len(compensator.alphas),
        widest=widest,
        rate=_number(compensator.rate_hz),
        mean=_number(compensator.scaling_in.mean),
        inverse=_number(1.0 / compensator.scaling_in.scale),
        alphas=_numbers(compensator.alphas),
        log_keep=_numbers(log_keep),
        lengths=_numbers(lengths - 0.5),
        tables="\n".join(tables),
        calls="\n".join(calls),
        offset=_number(compensator.scaling_out.mean),
        inputs=compensator.input_count,
        needs=needs,
        **pieces(compensator, name),
    )


def code_bytes(header: str, name: str) -> int | None:
    """Machine code of ``update`` and ``reset`` as this machine's gcc makes it (-Os); None without a compiler."""
    if shutil.which("gcc") is None or shutil.which("size") is None:
        return None
    caller = (
        f'#include "h.h"\nfloat u({name}_state *s, float g, float t) {{ return {name}_update(s, g, t); }}\n'
        f"void r({name}_state *s) {{ {name}_reset(s); }}\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "h.h").write_text(header)
        Path(folder, "u.c").write_text(caller)
        subprocess.run(["gcc", "-Os", "-c", "u.c", "-o", "u.o"], cwd=folder, check=True)
        listing = subprocess.run(["size", "-A", "u.o"], cwd=folder, check=True, capture_output=True, text=True).stdout
    rows = (line.split() for line in listing.splitlines())
    return sum(int(row[1]) for row in rows if row and row[0].startswith(".text"))


def _folded(network: Network, compensator: Compensator) -> Network:
    """The last layer takes over the output's scale and the share in the mean."""
    share = compensator.scaling_out.scale / len(compensator.networks)
    return Network(
        (*network.weights[:-1], network.weights[-1] * share), (*network.biases[:-1], network.biases[-1] * share)
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
            f"    {name}_layer({source}, {weight.shape[0]}, {out}, {weight.shape[1]}, "
            f"{name}_w{index}_{layer}, {name}_b{index}_{layer}, {int(not last)});"
        )
        source = out
    return "\n".join([*lines, "    result += value;"])


def _number(value: float) -> str:
    text = repr(float(np.float32(value)))
    return f"{text}f"


def _numbers(values: NDArray) -> str:
    return ", ".join(_number(value) for value in values)


TEMPLATE = """\
/* Compensator for {target} ({unit}), written by knitbench {version}. Do not edit: export it again.
 *
 *   {name}_state s;
 *   {name}_reset(&s);
 *   float p = {name}_update(&s, conductance_S, dt_s);   // each sample; dt_s: seconds since the last one
 *
 * No heap, no library. Constants {needs.constants_bytes} bytes of flash, state {needs.state_bytes} bytes of RAM,
 * {needs.scratch_bytes} bytes of stack for values, {needs.multiplies} multiplications a sample.
 */
#ifndef {NAME}_COMPENSATOR_H
#define {NAME}_COMPENSATOR_H

#include <stdint.h>

#define {NAME}_FILTERS {filters}
#define {NAME}_WIDEST {widest}
#define {NAME}_RATE_HZ {rate}

typedef struct {{
    float forced[{NAME}_FILTERS]; /* response from a zero state */
    float fading[{NAME}_FILTERS]; /* what is left of the initial value */
    float start[{NAME}_FILTERS];  /* the initial value: mean of the first samples */
    float elapsed;                /* in steps of 1/rate, until every start is known */
    uint32_t seen;                /* samples so far, as long as a start is not known */
{history_state}}} {name}_state;

static const float {name}_alpha[{filters}] = {{{alphas}}};
static const float {name}_log_keep[{filters}] = {{{log_keep}}};
static const float {name}_start_steps[{filters}] = {{{lengths}}};
{history_tables}{tables}

static inline void {name}_reset({name}_state *s) {{
    for (int i = 0; i < {NAME}_FILTERS; i++) {{
        s->forced[i] = 0.0f;
        s->fading[i] = 1.0f;
        s->start[i] = 0.0f;
    }}
    s->elapsed = 0.0f;
    s->seen = 0;
{history_reset}}}

/* 1 - exp(x) for x <= 0, accurate near zero: a series after halving, then squared up again. */
static inline float {name}_gain(float x) {{
    int halvings = 0;
    if (x < -16.0f) return 1.0f;
    while (x < -0.5f) {{
        x *= 0.5f;
        halvings++;
    }}
    float y = x * (1.0f + x / 2.0f * (1.0f + x / 3.0f * (1.0f + x / 4.0f * (1.0f + x / 5.0f * (1.0f + x / 6.0f)))));
    while (halvings--) y *= y + 2.0f;
    return -y;
}}

static inline void {name}_layer(const float *in, int n_in, float *out, int n_out, const float *w, const float *b,
                                int relu) {{
    for (int j = 0; j < n_out; j++) {{
        float sum = b[j];
        for (int i = 0; i < n_in; i++) sum += w[j * n_in + i] * in[i];
        out[j] = relu && sum < 0.0f ? 0.0f : sum;
    }}
}}

/* Feed one sample: conductance in S, seconds since the last sample (ignored for the first). Returns {unit}. */
static inline float {name}_update({name}_state *s, float conductance_S, float dt_s) {{
    float features[{inputs}], even[{NAME}_WIDEST], odd[{NAME}_WIDEST], value, result = {offset};
    const float x = (conductance_S - {mean}) * {inverse};
    const float steps = s->seen ? dt_s * {NAME}_RATE_HZ : 0.0f;
    const int nominal = steps > 0.999999f && steps < 1.000001f;
    const int first = s->seen == 0;
    int starting = first;
    if (!first) s->elapsed += steps;
    for (int i = 0; i < {NAME}_FILTERS; i++) starting |= s->elapsed < {name}_start_steps[i];
    if (starting) {{
        s->seen++;
    }} else {{
        s->elapsed = {name}_start_steps[{filters} - 1] + 1.0e6f; /* no filter starts any more */
    }}
    for (int i = 0; i < {NAME}_FILTERS; i++) {{
        const float gain = nominal ? {name}_alpha[i] : {name}_gain({name}_log_keep[i] * steps);
        s->forced[i] += gain * (x - s->forced[i]);
        s->fading[i] -= gain * s->fading[i];
        if (s->seen == 1 || s->elapsed < {name}_start_steps[i]) s->start[i] += (x - s->start[i]) / (float)s->seen;
        features[i] = s->forced[i] + s->fading[i] * s->start[i];
    }}
{history_update}    (void)even;
    (void)odd;
{calls}
    return result;
}}

#endif
"""
