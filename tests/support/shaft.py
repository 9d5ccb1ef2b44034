"""Files as text: a column of two blocks, {joint} for more of its joints, two ports on them; a shaft in space."""

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

ROCKING = """
name = "rocking"
[joints]
stiffness = 1e9
damping = 2e-3
[[block]]
name = "shaft"
on = "base"
width = 0.9
depth = 0.7
height = 2.5
density = 2400.0
"""
