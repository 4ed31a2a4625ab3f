"""Mach4 programs: written, read, played as the controller will, and checked."""
