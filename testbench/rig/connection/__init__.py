"""The way to a rig: ports, and what comes through them with the time of its coming."""
