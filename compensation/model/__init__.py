"""The compensator itself: what it is, its file, and how it runs on a recording or sample by sample."""
