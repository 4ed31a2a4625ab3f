"""Results as files: what is written, and strictly checked when it is read again."""
