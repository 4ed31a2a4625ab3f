"""Laws of what the instruments make of force and conductance when they read them."""
