"""Figures of a report and of the studio, one file a subject; each is a Plotly figure as plain data."""
