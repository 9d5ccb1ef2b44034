"""Integrators: one file each, one function `attempt` each.

attempt(column, t, h) makes one step from work.start to work.end, accelerations included, and returns the estimated
error in parts of the tolerance; that by modes returns (code, error). traits.py lists the properties of the methods; the
stepping loop (stepping/) accepts the step and chooses the next.
"""
