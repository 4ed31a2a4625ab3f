"""What several pages show: fields, pictures, cards of running work."""
