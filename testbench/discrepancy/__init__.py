"""Model against measurement: where the model fails, which effect is missing, what adding it buys."""
