"""Running an exported ONNX model sample by sample: it keeps the state, the model does the rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from compensation.model.runtime import Status
from gcode.support.errors import UserError
from gcode.support.kinds import number


class OnnxStream:
    """The same as `compensation.model.streaming.CompensatorStream`, on an exported model.

    Parameters
    ----------
    path : path
        Written by ``compensation export --format onnx``.

    Attributes
    ----------
    value : float
        The last prediction, in `unit`.
    status : Status
        Of the last sample.
    unit : str
        "N" or "mm".
    margins : tuple of float, optional
        Added to a value: the ends of the interval that holds 90 % of the errors to be expected.
    """

    def __init__(self, path: str | Path) -> None:
        try:
            import onnxruntime
        except ImportError:
            raise UserError("an ONNX model needs onnxruntime to run: pip install 'knitbench[onnx]'") from None
        try:
            self._session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
            properties = self._session.get_modelmeta().custom_metadata_map
            self.rate_hz, self.unit = float(properties["rate_hz"]), properties["unit"]
            ends = [float(end) for end in properties.get("margins", "").split()]
            self.margins = (ends[0], ends[1]) if ends else None
        except Exception as error:  # onnxruntime's exceptions share no base class
            raise UserError(
                f"{path}: not a compensator in ONNX ({type(error).__name__}); write one with `compensation export`"
            ) from None
        self.reset()

    def reset(self) -> None:
        """Forget everything: the next sample is the first."""
        self._state = {item.name: np.zeros(item.shape) for item in self._session.get_inputs()[2:]}
        self._state["fading"] += 1.0
        # A faulty sample on a new state tells the value that stands before the first one.
        self.value, self.status = 0.0, Status.GOOD
        self.update(np.nan)
        self.status = Status.STARTING

    def update(self, conductance_S: float, dt_s: float | None = None) -> float:
        """Feed one sample; see `compensation.model.streaming.CompensatorStream.update`."""
        steps = 1.0 if dt_s is None else number("dt_s", dt_s) * self.rate_hz
        sample = {"conductance_S": np.array([number("conductance_S", conductance_S)]), "steps": np.array([steps])}
        prediction, status, *following = self._session.run(None, sample | self._state)
        self._state = dict(zip(self._state, following, strict=True))
        self.value, self.status = float(prediction[0]), Status(int(status[0]))
        return self.value
