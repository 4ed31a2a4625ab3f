"""What a sensor's past leaves behind: the smoothing bank, motion and play; numbers in, numbers out."""
