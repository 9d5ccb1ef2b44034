"""Integrators: one file each, one function `attempt` each.

attempt(column, t, h) makes one step from work.start to work.end, accelerations included, and returns (code, error): the
estimated error in parts of the tolerance, 0 where there is no estimate. What a method is good for is in traits.py;
accepting the step and choosing the next is the stepping loop's business (stepping/).
"""
