"""A model beside a measurement: where it fails, in numbers and words, and the ladder of models."""
