"""One model judged: fitted under its priors, and the log evidence for it."""
