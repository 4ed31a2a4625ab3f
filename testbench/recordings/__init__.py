"""One recording: its channels, its files and manifest, its checks, and how two clocks are aligned."""
