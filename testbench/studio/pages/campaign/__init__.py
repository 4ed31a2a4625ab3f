"""The pages of one campaign: its tabs, and where they lead to."""
