"""The next experiment, and a row of them."""
