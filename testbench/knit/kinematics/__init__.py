"""Laws that change which strain the knit really sees: slip, backlash, permanent set, how it was mounted."""
