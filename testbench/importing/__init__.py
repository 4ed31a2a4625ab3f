"""Other people's files: from a table as a laboratory wrote it to columns with known meaning and known units."""
