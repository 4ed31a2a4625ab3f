"""From a wish to a checked program: made, made again from its own header, drawn."""
