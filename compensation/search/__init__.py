"""The search over candidates and its ranking."""
