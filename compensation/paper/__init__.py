"""What the paper prints, and the same experiments on our recordings."""
