"""Model against measurement: fits, comparisons, the ladder of models, and experiments that tell models apart."""
