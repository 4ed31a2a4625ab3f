"""Motion of one axis over time: paths, speeds and accelerations, and what keeps them within limits."""
