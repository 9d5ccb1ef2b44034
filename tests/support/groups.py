"""Groups of machine code (solver/kernels/machine/groups.py) that no quick test needs."""

OF_LONG_TESTS = ("lanes_round_slipping", "lanes_strips", "lanes_rims")
