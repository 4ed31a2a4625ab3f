"""What comes in from files and goes out to them: imports, data sets, sealed cases, reports, checksums."""
