"""The rig, real or simulated: what it plays and records, and when."""
