"""Campaigns: plan them, play and record them, make them again, and gather them into data sets."""
