"""From recordings to a compensator: the paper's network, the tuned ones, the automatic choice, the twin."""
