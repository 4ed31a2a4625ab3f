"""Motions that the tests of the physics share."""

from __future__ import annotations

import numpy as np

UP = np.linspace(0, 0.3, 301)
UP_DOWN_UP = np.concatenate([UP, UP[::-1][1:], UP[1:]])
