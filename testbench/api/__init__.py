"""The public functions of `testbench`, one module a verb; the command line and the studio are thin users of them."""
