"""A model fitted to measurements: the wide base, its parameters and their errors, and the files of models."""
