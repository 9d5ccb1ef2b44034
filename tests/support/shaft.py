"""A column of two blocks as text of a file, {joint} for more of its joints, and two ports on them."""

SHAFT = """
name = "shaft"
[joint]
stiffness = 5e9
damping = 1e-3
{joint}
[solver]
tolerance = 1e-8
[[block]]
repeat = 2
height = 3.0
width = 1.2
depth = 1.2
density = 2500.0
"""
PORTS = """
[[port]]
name = "top"
block = "block1"
at = [0.2, 1.5]
[[port]]
name = "lower"
block = "block2"
"""
