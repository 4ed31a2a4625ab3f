"""A compensator as an ONNX model of one step: sample and state in, prediction and next state out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from compensation.compensator import Compensator
from compensation.ema import start_samples
from compensation.history import SETTLE_S
from gcode.support.errors import UserError
from gcode.support.files import atomic_path

OPSET = 17


def write_onnx(compensator: Compensator, path: str | Path) -> None:
    """Write the streaming step as ONNX (double precision).

    Inputs ``conductance_S`` (1,), ``steps`` (1,) = dt times the rate, and the state ``forced``, ``fading``, ``sums``,
    ``seen`` (each (k,)) and ``elapsed`` (1,); with other memories also ``settled`` (1,), ``motion`` and ``play``.
    Start with zeros, ``fading`` with ones, and ``steps`` 0 at the first sample.
    Outputs ``prediction`` (1,) and the state again with ``next_`` before its names.

    Raises
    ------
    UserError
        If the `onnx` package is missing or the compensator needs a whole recording.
    """
    try:
        import onnx
    except ImportError:
        raise UserError("ONNX export needs the onnx package: pip install 'knitbench[onnx]'") from None
    if compensator.per_recording:
        raise UserError("a compensator trained with --per-recording needs the whole recording; train without it")
    model = _model(compensator)
    onnx.checker.check_model(model)
    with atomic_path(path) as temporary:
        onnx.save(model, str(temporary))


class _Graph:
    """Nodes and constants, named as they are added."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def constant(self, name: str, values: Any) -> str:
        from onnx import numpy_helper

        self.constants.append(numpy_helper.from_array(np.asarray(values, dtype=np.float64), name))
        return name

    def __call__(self, kind: str, *inputs: str, out: str | None = None, **attributes: Any) -> str:
        from onnx import TensorProto, helper

        if kind == "Number":
            kind, attributes = "Cast", {"to": TensorProto.DOUBLE}
        name = out or f"{kind}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [name], **attributes))
        return name


def _model(compensator: Compensator) -> Any:
    from onnx import TensorProto, helper

    filters = len(compensator.alphas)
    graph = _Graph()
    features = _with_history(graph, compensator, *_bank(graph, compensator))
    _networks(graph, compensator, features)
    state = {"forced": filters, "fading": filters, "sums": filters, "seen": filters, "elapsed": 1}
    history = compensator.history
    if history.count:
        state["settled"] = 1
    if history.motion_taus_s:
        state["motion"] = len(history.motion_taus_s)
    if history.play_radii:
        state["play"] = len(history.play_radii)

    def value(name: str, size: int) -> Any:
        return helper.make_tensor_value_info(name, TensorProto.DOUBLE, [size])

    inputs = [value("conductance_S", 1), value("steps", 1), *(value(*item) for item in state.items())]
    outputs = [value("prediction", 1), *(value(f"next_{name}", size) for name, size in state.items())]
    body = helper.make_graph(graph.nodes, "compensator_step", inputs, outputs, graph.constants)
    # IR 8 goes with opset 17: older runtimes on small boards read it.
    return helper.make_model(body, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=8)


def _bank(graph: _Graph, compensator: Compensator) -> tuple[str, str, str]:
    """Names of the standardised sample, of "this is not the first sample", and of the smoothed values."""
    log_keep = np.log1p(-np.minimum(compensator.alphas, 1 - 1e-16))
    centred = graph("Sub", "conductance_S", graph.constant("mean_in", [compensator.scaling_in.mean]))
    x = graph("Div", centred, graph.constant("scale_in", [compensator.scaling_in.scale]))
    keep = graph("Exp", graph("Mul", graph.constant("log_keep", log_keep), "steps"))
    moved = graph("Mul", keep, graph("Sub", "forced", x))
    # No step, no input: the first sample only starts the filters.
    later = graph("Greater", "steps", graph.constant("zero", [0.0]))
    forced = graph("Where", later, graph("Add", x, moved), "forced")
    graph("Identity", forced, out="next_forced")
    fading = graph("Mul", "fading", keep, out="next_fading")
    elapsed = graph("Add", "elapsed", "steps", out="next_elapsed")
    lengths = start_samples(compensator.alphas, compensator.rate_hz) - 0.5
    early = graph("Less", elapsed, graph.constant("start_steps", lengths))
    first = graph("Equal", "seen", "zero")
    starting = graph("Number", graph("Or", early, first))
    sums = graph("Add", "sums", graph("Mul", starting, x), out="next_sums")
    seen = graph("Add", "seen", starting, out="next_seen")
    return x, later, graph("Add", forced, graph("Mul", fading, graph("Div", sums, seen)))


def _with_history(graph: _Graph, compensator: Compensator, x: str, later: str, smoothed: str) -> str:
    """The features with those of `compensation.history` behind them."""
    history, parts = compensator.history, [smoothed]
    if not history.count:
        return smoothed
    dt = graph("Div", "steps", graph.constant("rate", [compensator.rate_hz]))

    def gain(name: str, taus_s: Sequence[float]) -> str:
        decay = graph("Exp", graph("Mul", dt, graph.constant(name, -1.0 / np.asarray(taus_s))))
        return graph("Sub", graph.constant(f"{name}_one", [1.0]), decay)

    step = graph("Mul", gain("settle", [SETTLE_S]), graph("Sub", x, "settled"))
    settled = graph("Where", later, graph("Add", "settled", step), x, out="next_settled")
    if history.motion_taus_s:
        safe = graph("Max", dt, graph.constant("instant", [1e-9]))
        change = graph("Sub", graph("Div", graph("Abs", step), safe), "motion")
        moved = graph("Add", "motion", graph("Mul", gain("motion_per_s", history.motion_taus_s), change))
        parts.append(graph("Where", later, moved, "motion", out="next_motion"))
    if history.play_radii:
        radii = graph.constant("radii", history.play_radii)
        low, high = graph("Sub", settled, radii), graph("Add", settled, radii)
        held = graph("Max", low, graph("Min", high, "play"))
        parts.append(graph("Where", later, held, settled, out="next_play"))
    return graph("Concat", *parts, axis=0)


def _networks(graph: _Graph, compensator: Compensator, features: str) -> None:
    outputs = []
    for index, network in enumerate(compensator.networks):
        value = features
        for layer, (weight, bias) in enumerate(zip(network.weights, network.biases, strict=True)):
            product = graph("MatMul", value, graph.constant(f"w{index}_{layer}", weight))
            value = graph("Add", product, graph.constant(f"b{index}_{layer}", bias))
            if layer < len(network.weights) - 1:
                value = graph("Relu", value)
        outputs.append(value)
    total = outputs[0]
    for output in outputs[1:]:
        total = graph("Add", total, output)
    share = compensator.scaling_out.scale / len(outputs)
    scaled = graph("Mul", total, graph.constant("scale_out", [share]))
    graph("Add", scaled, graph.constant("mean_out", [compensator.scaling_out.mean]), out="prediction")
