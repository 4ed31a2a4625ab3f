"""What is wanted of a motion, as pieces and limits, and the trajectory that is planned from it."""
