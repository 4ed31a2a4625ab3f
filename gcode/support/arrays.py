"""The one name for an array of floating-point numbers, and for one of whole numbers."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

FloatArray = NDArray[Any]
IntArray = NDArray[Any]
