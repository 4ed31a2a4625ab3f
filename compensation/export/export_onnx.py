"""A compensator as an ONNX model of one step: sample and state in, prediction and next state out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from compensation.memories.ema import log_retention, start_steps
from compensation.model.compensator import Fitted, TrainedCompensator
from compensation.model.runtime import READINGS_S, STEPS_S, Status, limits_of, ranges_of, streamable
from gcode.support.errors import UserError
from gcode.support.files import atomic_path

OPSET = 17
ZERO = (0.0,)


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
    compensator = streamable(compensator)
    model = _model(compensator)
    onnx.checker.check_model(model)
    with atomic_path(path) as temporary:
        onnx.save(model, str(temporary))


class _Graph:
    """Nodes, and the numbers that go into them."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def _named(self, value: Any) -> str:
        """Name of a node's input: a name as it is, numbers as a new constant."""
        from onnx import numpy_helper

        if isinstance(value, str):
            return value
        name = f"constant_{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.asarray(value), name))
        return name

    def __call__(self, kind: str, *inputs: Any, out: str | None = None, **attributes: Any) -> str:
        from onnx import TensorProto, helper

        if kind == "Number":
            kind, attributes = "Cast", {"to": TensorProto.DOUBLE}
        name = out or f"{kind}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, [self._named(value) for value in inputs], [name], **attributes))
        return name


def state_of(compensator: TrainedCompensator) -> dict[str, int]:
    """Names and sizes of the state."""
    filters, history = len(compensator.alphas), compensator.history
    state = {"forced": filters, "fading": filters, "sums": filters, "seen": filters, "elapsed": 1, "last": 1}
    state |= {"settled": min(history.count, 1), "motion": len(history.motion_taus_s), "play": len(history.play_radii)}
    return {name: size for name, size in state.items() if size}


def _model(compensator: TrainedCompensator) -> Any:
    from onnx import TensorProto, helper

    graph, state = _Graph(), state_of(compensator)
    fault = _fault(graph, compensator)
    features, x, starting = _features(graph, compensator)
    _networks(graph, compensator, features)
    _status(graph, compensator, fault, features, x, starting)
    good = graph("Equal", fault, ZERO)
    # Last of all: where the sample is faulty, everything is as it was.
    start = graph("Where", graph("Equal", "counted", ZERO), [compensator.scaling_out.mean], "last")
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
    # One filter's count is enough: zero before the first good sample.
    graph("Slice", "seen", [0], [1], out="counted")
    step = graph("Where", graph("Equal", "counted", ZERO), [1.0], "steps")
    flags = []
    for source, low, high, flag in (
        ("conductance_S", READINGS_S[0], READINGS_S[1], Status.BAD_READING),
        (step, STEPS_S[0] * rate_hz, STEPS_S[1] * rate_hz, Status.BAD_STEP),
    ):
        within = graph("And", graph("GreaterOrEqual", source, [low]), graph("LessOrEqual", source, [high]))
        flags.append(graph("Mul", graph("Number", graph("Not", within)), [float(flag)]))
    return graph("Add", *flags)


def _status(
    graph: _Graph, compensator: TrainedCompensator, fault: str, features: str, reading: str, starting: str
) -> None:
    """What is out of the range of the training, or, where the sample is faulty, that."""
    seen = ranges_of(compensator)

    def outside(source: str, low: Any, high: Any) -> str:
        return graph("Number", graph("Or", graph("Less", source, low), graph("Greater", source, high)))

    strange = outside(reading, [seen.low], [seen.high])
    unknown = graph("ReduceMax", outside(features, seen.inputs_low, seen.inputs_high), axes=[0])
    begun = graph("ReduceMax", starting, axes=[0])
    flags = ((strange, Status.UNSEEN_READING), (unknown, Status.UNSEEN_HISTORY), (begun, Status.STARTING))
    terms = [graph("Mul", name, [float(flag)]) for name, flag in flags]
    graph("Where", graph("Equal", fault, ZERO), graph("Sum", *terms), fault, out="status")


def _features(graph: _Graph, compensator: TrainedCompensator) -> tuple[str, str, str]:
    """Names of the networks' inputs, of the standardised reading, and of "this filter is still starting"."""
    filters, begin = len(compensator.alphas), compensator.begins
    low, high = limits_of(compensator)
    centred = graph("Sub", "conductance_S", [compensator.scaling_in.mean])
    reading = graph("Div", centred, [compensator.scaling_in.scale])
    x = graph("Min", graph("Max", reading, [low]), [high])
    later = graph("Greater", "counted", ZERO)
    # No step, no input: the first sample only starts the filters.
    steps = graph("Where", later, "steps", ZERO)
    keep = graph("Exp", graph("Mul", log_retention(compensator.alphas), steps))
    moved = graph("Mul", keep, graph("Sub", "forced", x))
    forced = graph("Where", later, graph("Add", x, moved), "forced", out="fresh_forced")
    fading = graph("Mul", "fading", keep, out="fresh_fading")
    elapsed = graph("Add", "elapsed", steps, out="fresh_elapsed")
    early = graph("Less", elapsed, start_steps(compensator.alphas, compensator.rate_hz))
    starting = graph("Number", graph("Or", early, graph("Equal", "seen", ZERO)))
    sums = graph("Add", "sums", graph("Mul", starting, x), out="fresh_sums")
    seen = graph("Add", "seen", starting, out="fresh_seen")
    told = graph("Mul", begin.gain[:filters], graph("Div", sums, seen))
    initial = graph("Add", begin.offset[:filters], told)
    smoothed = graph("Add", forced, graph("Mul", fading, initial))
    return _with_history(graph, compensator, x, later, steps, smoothed), reading, starting


def _with_history(
    graph: _Graph, compensator: TrainedCompensator, x: str, later: str, steps: str, smoothed: str
) -> str:
    """The features with those of `compensation.memories.history` behind them."""
    history, parts, begin = compensator.history, [smoothed], compensator.begins
    if not history.count:
        return smoothed
    dt = graph("Div", steps, [compensator.rate_hz])
    motions, at = len(history.motion_taus_s), len(compensator.alphas)

    def gain(taus_s: Sequence[float]) -> str:
        return graph("Sub", [1.0], graph("Exp", graph("Mul", dt, -1.0 / np.asarray(taus_s))))

    def begun(rows: slice) -> str:
        return graph("Add", begin.offset[rows], graph("Mul", begin.gain[rows], x))

    step = graph("Mul", gain([history.settle_s]), graph("Sub", x, "settled"))
    settled = graph("Where", later, graph("Add", "settled", step), x, out="fresh_settled")
    if history.motion_taus_s:
        speed = graph("Div", graph("Abs", step), graph("Max", dt, [1e-9]))  # no division by the first sample's zero
        change = graph("Mul", gain(history.motion_taus_s), graph("Sub", speed, "motion"))
        moved = graph("Add", "motion", change)
        parts.append(graph("Where", later, moved, begun(slice(at, at + motions)), out="fresh_motion"))
    if history.play_radii:
        low, high = graph("Sub", settled, history.play_radii), graph("Add", settled, history.play_radii)
        held = graph("Where", later, "play", begun(slice(at + motions, None)))
        parts.append(graph("Max", low, graph("Min", high, held), out="fresh_play"))
    return graph("Concat", *parts, axis=0)


def _networks(graph: _Graph, compensator: TrainedCompensator, features: str) -> None:
    outputs = []
    for network in compensator.networks:
        value = features
        for layer, (weight, bias) in enumerate(zip(network.weights, network.biases, strict=True)):
            value = graph("Add", graph("MatMul", value, weight), bias)
            if layer < len(network.weights) - 1:
                value = graph("Relu", value)
        outputs.append(value)
    share = compensator.scaling_out.scale / len(outputs)
    graph(
        "Add", graph("Mul", graph("Sum", *outputs), [share]), [compensator.scaling_out.mean], out="fresh_prediction"
    )
