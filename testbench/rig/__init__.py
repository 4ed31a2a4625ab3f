"""The test bench, real or simulated: the lines that it sends, the way they come, and the recorder that keeps them."""
