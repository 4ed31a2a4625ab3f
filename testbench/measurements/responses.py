"""What a model is fitted to: the responses to the motion, the signals that they come from, and their units."""

from __future__ import annotations

FORCE_CHANNEL, CONDUCTANCE_CHANNEL = "force", "conductance"
SIGNAL_OF = {FORCE_CHANNEL: "force_N", CONDUCTANCE_CHANNEL: "conductance_S"}
UNIT_OF = {FORCE_CHANNEL: "N", CONDUCTANCE_CHANNEL: "ln S"}
