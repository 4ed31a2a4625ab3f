"""Motions of the carriage: band-limited noise, with holds, a rest and triangles put in at its turns."""

from worlds_fourth.motion.motion import make_motion

__all__ = ["make_motion"]
