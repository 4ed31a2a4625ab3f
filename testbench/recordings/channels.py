"""Names and units of the channels of a recording."""

from __future__ import annotations

TIME, DISPLACEMENT, FORCE, RESISTANCE = "time_s", "displacement_mm", "force_N", "resistance_ohm"
TEMPERATURE = "temperature_C"
UNITS = {TIME: "s", DISPLACEMENT: "mm", FORCE: "N", RESISTANCE: "ohm", TEMPERATURE: "degC"}
