"""Other people's recordings: from a file as a laboratory wrote it to columns with known meaning and known units."""
