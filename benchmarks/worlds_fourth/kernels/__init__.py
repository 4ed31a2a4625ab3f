"""Loops over samples that no array formula does, compiled: memories of time, of the way and of turning points."""
