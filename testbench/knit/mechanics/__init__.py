"""Laws of the force with which the knit answers a strain, before any instrument reads it."""
