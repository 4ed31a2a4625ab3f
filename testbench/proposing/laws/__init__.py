"""What a proposed law is: a place in the chain, and operators on a coordinate, with dimensions and a formula."""
