"""The physics of a knitted sensor: effects, one room a stage, and the chain of stages that simulates them."""
