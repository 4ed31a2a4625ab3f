"""One way to judge: evidences, what is put in, and the probabilities that follow."""
