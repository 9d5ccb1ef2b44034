"""Integrators: one file each, one function `attempt` each.

attempt(model, inputs, work, counters, scale, rate_scale, t, h) makes one step from the phase PHASE_START of the work
array to PHASE_END, accelerations included, and returns (code, error): the estimated error in parts of the tolerance, 0
where there is no estimate. Accepting the step and choosing the next is the stepping loop's business (advance.py).
"""
