"""Campaigns: plan them, play and record them, make them again; many of them make a data set (`datasets`)."""
