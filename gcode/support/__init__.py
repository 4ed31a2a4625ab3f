"""What all three packages share and none of them is about: errors, safe files, the command-line frame.

It lives in `gcode` because that is the lowest layer (see docs/decisions/0001-support.md).
"""
