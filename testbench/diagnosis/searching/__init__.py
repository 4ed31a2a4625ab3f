"""Many ways to propose: models of one measurement, what each law promises beside them, and their refits."""
