"""A compensator as an ONNX model of one step: sample and state in, prediction and next state out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from compensation.memories.ema import log_retention, start_steps
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
from gcode.support.errors import UserError
from gcode.support.files import atomic_path

OPSET = 17


def write_onnx(compensator: TrainedCompensator | Fitted, path: str | Path) -> None:
    """Write one step of a compensator as an ONNX model in double precision.

    Inputs are ``conductance_S``, shape (1,), in S; ``steps``, shape (1,), the time since the last good sample in s,
    times the compensator's rate in Hz; and the state: ``forced``, ``fading``, ``sums`` and ``seen``, each shape (k,)
    for k smoothing filters, ``elapsed`` and ``last``, each shape (1,); where motion or play is remembered also
    ``settled``, shape (1,), ``motion`` and ``play``, one value a memory. At the
    start ``fading`` holds ones, all else zeros.

    Outputs are ``prediction``, shape (1,), in N or mm; ``status``, shape (1,), the flags of
    `compensation.model.runtime.Status`; and the next state, with ``next_`` before each name. A faulty sample gives
    the state as it was and the last prediction. `compensation.export.onnx_stream.OnnxStream` keeps the state.

    Parameters
    ----------
    compensator : TrainedCompensator or Compensator
        As loaded, or fitted.
    path : path
        File to write; a file that is there is replaced.

    Raises
    ------
    UserError
        If the `onnx` package is missing, or the compensator standardises each recording by itself, which needs all
        of it.

    Examples
    --------
    >>> import tempfile
    >>> import testbench as tb
    >>> from compensation import Compensator, write_onnx
    >>> from compensation.export.onnx_stream import OnnxStream
    >>> recording = tb.example(duration_s=60).resampled(20.0)
    >>> model = Compensator(method="paper").fit(recording.conductance_S[:, None], recording["force_N"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_onnx(model, f"{folder}/knit.onnx")
    ...     exported = OnnxStream(f"{folder}/knit.onnx")
    >>> round(exported.update(1.6e-6) - model.stream().update(1.6e-6), 9)
    0.0
    """
    try:
        import onnx
    except ImportError:
        raise UserError("ONNX export needs the onnx package: pip install 'knitbench[onnx]'") from None
    compensator = trained(compensator)
    check_streams(compensator)
    model = _model(compensator)
    onnx.checker.check_model(model)
    with atomic_path(path) as temporary:
        onnx.save(model, str(temporary))


class _Graph:
    """Nodes and constants, named as they are added."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def constant(self, name: str, values: Any, kind: type = np.float64) -> str:
        from onnx import numpy_helper

        self.constants.append(numpy_helper.from_array(np.asarray(values, dtype=kind), name))
        return name

    def __call__(self, kind: str, *inputs: str, out: str | None = None, **attributes: Any) -> str:
        from onnx import TensorProto, helper

        if kind == "Number":
            kind, attributes = "Cast", {"to": TensorProto.DOUBLE}
        name = out or f"{kind}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [name], **attributes))
        return name


def state_of(compensator: TrainedCompensator) -> dict[str, int]:
    """Names and sizes of the state."""
    filters, history = len(compensator.alphas), compensator.history
    state = {"forced": filters, "fading": filters, "sums": filters, "seen": filters, "elapsed": 1, "last": 1}
    if history.count:
        state["settled"] = 1
    if history.motion_taus_s:
        state["motion"] = len(history.motion_taus_s)
    if history.play_radii:
        state["play"] = len(history.play_radii)
    return state


def _model(compensator: TrainedCompensator) -> Any:
    from onnx import TensorProto, helper

    graph, state = _Graph(), state_of(compensator)
    fault = _fault(graph, compensator)
    features, x, starting = _features(graph, compensator)
    _networks(graph, compensator, features)
    _status(graph, compensator, fault, features, x, starting)
    good = graph("Equal", fault, "zero")
    # Last of all: where the sample is faulty, everything is as it was.
    start = graph(
        "Where",
        graph("Equal", "counted", "zero"),
        graph.constant("mean_last", [compensator.scaling_out.mean]),
        "last",
    )
    graph("Where", good, "fresh_prediction", start, out="prediction")
    graph("Where", good, "prediction", "last", out="next_last")
    for name in state:
        if name != "last":
            graph("Where", good, f"fresh_{name}", name, out=f"next_{name}")

    def value(name: str, size: int) -> Any:
        return helper.make_tensor_value_info(name, TensorProto.DOUBLE, [size])

    inputs = [value("conductance_S", 1), value("steps", 1), *(value(*item) for item in state.items())]
    outputs = [value("prediction", 1), value("status", 1)]
    outputs += [value(f"next_{name}", size) for name, size in state.items()]
    body = helper.make_graph(graph.nodes, "compensator_step", inputs, outputs, graph.constants)
    # IR 8 goes with opset 17: older runtimes on small boards read it.
    model = helper.make_model(body, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=8)
    properties = {"rate_hz": repr(compensator.rate_hz), "unit": compensator.unit}
    if compensator.margins is not None:
        properties["margins"] = " ".join(map(repr, compensator.margins))
    helper.set_model_props(model, properties)
    return model


def _fault(graph: _Graph, compensator: TrainedCompensator) -> str:
    """Name of the flags that say what is wrong with the sample itself; comparisons with a NaN are false."""
    rate_hz = compensator.rate_hz
    graph.constant("zero", [0.0])
    # One filter's count is enough: zero before the first good sample.
    graph("Slice", "seen", *(graph.constant(f"slice_{k}", [k], np.int64) for k in (0, 1)), out="counted")
    first = graph("Equal", "counted", "zero")
    step = graph("Where", first, graph.constant("one", [1.0]), "steps")
    flags = []
    for name, source, low, high, flag in (
        ("reading", "conductance_S", SMALLEST_CONDUCTANCE_S, LARGEST_CONDUCTANCE_S, Status.BAD_READING),
        ("step", step, SHORTEST_STEP_S * rate_hz, LONGEST_STEP_S * rate_hz, Status.BAD_STEP),
    ):
        above = graph("GreaterOrEqual", source, graph.constant(f"{name}_low", [low]))
        below = graph("LessOrEqual", source, graph.constant(f"{name}_high", [high]))
        wrong = graph("Number", graph("Not", graph("And", above, below)))
        flags.append(graph("Mul", wrong, graph.constant(f"{name}_flag", [float(flag)])))
    return graph("Add", *flags)


def _status(
    graph: _Graph, compensator: TrainedCompensator, fault: str, features: str, reading: str, starting: str
) -> None:
    """What is out of the range of the training, or, where the sample is faulty, that."""
    seen = ranges_of(compensator)

    def outside(name: str, source: str, low: Any, high: Any) -> str:
        below = graph("Less", source, graph.constant(f"{name}_low", low))
        return graph("Number", graph("Or", below, graph("Greater", source, graph.constant(f"{name}_high", high))))

    strange = outside("seen", reading, [seen.low], [seen.high])
    unknown = graph("ReduceMax", outside("inputs", features, seen.inputs_low, seen.inputs_high), axes=[0])
    begun = graph("ReduceMax", starting, axes=[0])
    flags = ((strange, Status.UNSEEN_READING), (unknown, Status.UNSEEN_HISTORY), (begun, Status.STARTING))
    terms = [graph("Mul", name, graph.constant(f"flag_{flag.name}", [float(flag)])) for name, flag in flags]
    total = graph("Add", graph("Add", terms[0], terms[1]), terms[2])
    graph("Where", graph("Equal", fault, "zero"), total, fault, out="status")


def _features(graph: _Graph, compensator: TrainedCompensator) -> tuple[str, str, str]:
    """Names of the networks' inputs, of the standardised reading, and of "this filter is still starting"."""
    filters, begin, limits = len(compensator.alphas), beginning_of(compensator), limits_of(compensator)
    centred = graph("Sub", "conductance_S", graph.constant("mean_in", [compensator.scaling_in.mean]))
    reading = graph("Div", centred, graph.constant("scale_in", [compensator.scaling_in.scale]))
    raised = graph("Max", reading, graph.constant("limit_low", [limits[0]]))
    x = graph("Min", raised, graph.constant("limit_high", [limits[1]]))
    later = graph("Greater", "counted", "zero")
    # No step, no input: the first sample only starts the filters.
    steps = graph("Where", later, "steps", "zero")
    keep = graph("Exp", graph("Mul", graph.constant("log_keep", log_retention(compensator.alphas)), steps))
    moved = graph("Mul", keep, graph("Sub", "forced", x))
    forced = graph("Where", later, graph("Add", x, moved), "forced", out="fresh_forced")
    fading = graph("Mul", "fading", keep, out="fresh_fading")
    elapsed = graph("Add", "elapsed", steps, out="fresh_elapsed")
    lengths = start_steps(compensator.alphas, compensator.rate_hz)
    early = graph("Less", elapsed, graph.constant("start_steps", lengths))
    starting = graph("Number", graph("Or", early, graph("Equal", "seen", "zero")))
    sums = graph("Add", "sums", graph("Mul", starting, x), out="fresh_sums")
    seen = graph("Add", "seen", starting, out="fresh_seen")
    told = graph("Mul", graph.constant("begin_gain", begin.gain[:filters]), graph("Div", sums, seen))
    initial = graph("Add", graph.constant("begin_offset", begin.offset[:filters]), told)
    smoothed = graph("Add", forced, graph("Mul", fading, initial))
    return _with_history(graph, compensator, x, later, steps, smoothed), reading, starting


def _with_history(
    graph: _Graph, compensator: TrainedCompensator, x: str, later: str, steps: str, smoothed: str
) -> str:
    """The features with those of `compensation.memories.history` behind them."""
    history, parts, begin = compensator.history, [smoothed], beginning_of(compensator)
    if not history.count:
        return smoothed
    dt = graph("Div", steps, graph.constant("rate", [compensator.rate_hz]))
    motions, at = len(history.motion_taus_s), len(compensator.alphas)

    def gain(name: str, taus_s: Sequence[float]) -> str:
        decay = graph("Exp", graph("Mul", dt, graph.constant(name, -1.0 / np.asarray(taus_s))))
        return graph("Sub", graph.constant(f"{name}_one", [1.0]), decay)

    def begun(name: str, rows: slice) -> str:
        told = graph("Mul", graph.constant(f"{name}_begin_gain", begin.gain[rows]), x)
        return graph("Add", graph.constant(f"{name}_begin_offset", begin.offset[rows]), told)

    step = graph("Mul", gain("settle", [history.settle_s]), graph("Sub", x, "settled"))
    settled = graph("Where", later, graph("Add", "settled", step), x, out="fresh_settled")
    if history.motion_taus_s:
        safe = graph("Max", dt, graph.constant("instant", [1e-9]))
        change = graph("Sub", graph("Div", graph("Abs", step), safe), "motion")
        moved = graph("Add", "motion", graph("Mul", gain("motion_per_s", history.motion_taus_s), change))
        parts.append(graph("Where", later, moved, begun("motion", slice(at, at + motions)), out="fresh_motion"))
    if history.play_radii:
        radii = graph.constant("radii", history.play_radii)
        low, high = graph("Sub", settled, radii), graph("Add", settled, radii)
        held = graph("Where", later, "play", begun("play", slice(at + motions, None)))
        parts.append(graph("Max", low, graph("Min", high, held), out="fresh_play"))
    return graph("Concat", *parts, axis=0)


def _networks(graph: _Graph, compensator: TrainedCompensator, features: str) -> None:
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
    graph("Add", scaled, graph.constant("mean_out", [compensator.scaling_out.mean]), out="fresh_prediction")
