"""Which physical effect is missing: models compared by their evidence."""
