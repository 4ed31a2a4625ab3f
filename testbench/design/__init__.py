"""The next experiment: motions that tell the models apart that are still likely."""
