"""The lines that a rig sends: from bytes to samples, and from samples to the rows of a recording."""
