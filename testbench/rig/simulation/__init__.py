"""A rig that is not there: it moves, reads and sends as a real one does."""
