"""Data sets: thousands of simulated campaigns from one file, split, checked, and as Parquet files."""
