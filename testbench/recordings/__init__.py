"""One recording: its channels, its files and manifest and its checks."""
