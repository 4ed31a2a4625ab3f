"""Recordings made ready to be compared with a model: on one grid, with their noise and their history."""
