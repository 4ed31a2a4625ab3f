"""The physics of a knitted sensor: effects, and the chain of stages that simulates them; one room a stage."""
