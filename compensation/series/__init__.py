"""Recordings as input and target, and how well a prediction follows the truth."""
