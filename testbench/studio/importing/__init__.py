"""The form with which a file of another tester is imported: what it looks like, what was taken for what."""
