"""A model at its best on a measurement: the wide base, its parameters and their errors, and its evidence."""
