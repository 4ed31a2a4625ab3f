"""Figures and pages: recordings, models and results as one report, each section made from plain results."""
