"""The integrators: a module each, with a function `attempt`.

`attempt(column, t, h)` makes one step from `work.start` to `work.end`, accelerations included, and returns the
estimated error in tolerances; that of the modal method returns (code, error). traits.py lists the properties of the
methods; the stepping loop (stepping/) accepts the step and chooses the next.
"""
