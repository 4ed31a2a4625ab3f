"""All forms of all hidden effects: importing the files registers them."""

from testbench.worlds import forms_electrical, forms_grip, forms_mechanics, forms_readout, forms_unknown
from testbench.worlds.registry import FORMS, UNKNOWN

FILES = (forms_mechanics, forms_grip, forms_electrical, forms_readout, forms_unknown)

__all__ = ["FILES", "FORMS", "UNKNOWN"]
