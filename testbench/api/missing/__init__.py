"""What a model is missing: an effect of the catalogue, or a law that nobody has written down yet."""
