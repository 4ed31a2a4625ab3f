"""Laws of the conductance: what presses the contacts, what they conduct, and what becomes of it afterwards."""
