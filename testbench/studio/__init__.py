"""The studio: the test bench as a local web app. It shows and calls; the command line knows all that it knows."""
