"""Recording: every sample to the disk, until the motion is over, and on from there after a kill."""
