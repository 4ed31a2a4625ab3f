"""A model: fitted, beside a measurement, with effects put in and taken out."""
