"""How laboratories write things down: numbers, units, and the names of the columns."""
