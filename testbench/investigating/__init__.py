"""The closed loop: plan, run, diagnose, design the motion that separates what is still likely, run it."""
