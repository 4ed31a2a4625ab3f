"""A report as a file: one HTML page, Markdown, and its figures as PNG and PDF."""
