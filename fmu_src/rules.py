"""Rules of both FMUs, and their messages, shared by the Python slave and the native core (native/table.py).

The messages are formats of C's printf, which Python's % supports as well.
"""

from __future__ import annotations

from solver.common.errors import FINITE

TIME_SLACK = 1e-6  # of a step: tolerance on the start of a step against the end of the last one
STEP_SLACK = 1e-6  # of a sampling interval: tolerance on a communication step of the same length
SCALE_LIMITS = (FINITE, "a finite number")  # of the factor on the record
STILL = 1e-6  # m/s2 and so on: a smaller motion of a base that bodies drive is rounding error
DAMPING_SCALE_LIMITS = ((0.0, 1e6), "a factor from 0 to 1e6")  # of the factor on the damping of a structure

# the life of an instance
WRONG_MODE = "%s: the slave is in the state %s"
WHEN_SET_UP = "the experiment can be set up after instantiation or reset only"
WHEN_ENTERED = "initialization can begin after instantiation or reset only"
WHEN_EXITED = "initialization can end after it has begun only"
WHEN_TERMINATED = "a run can be terminated after initialization only"
START_TIME = "start time = %s: must be a finite time in s"
STOP_TIME = "stop time = %s: must be a time from the start time %s s on"
TOLERANCE = "solver.tolerance = %s, the experiment's tolerance"
NOT_SHAKEN = "the base acceleration was zero for the whole run: is the input connected?"
NOT_DRIVEN = "the base never moved in the whole run: is body.F0x of what drives it connected?"

# variables
NOT_READ = "variables at t = %s s: %s"
NO_VARIABLE = "value reference %u: is not that of a %s variable"
NOT_SETTABLE = "value reference %u: is not an input or a parameter of the kind %s"
NOTHING_SET = "nothing can be set, the run is terminated"
FIXED = "%s: can be set before the end of initialization only"
IDLE = "%s does nothing%s: base.drive = %s, %s"
IDLE_LATER = " after the first exchange"
BY_ACCELERATION = "the base moves as base.ax and its like say"
BY_BODY = "the bodies at the base move it"
BY_HORIZONTAL = "the bodies at the base move it horizontally, its other motion is given by base.az and its like"
TOO_EARLY = "outputs can be read from initialization on"

# steps
NOT_MADE = "step from t = %s s of %s s not made: %s"
ENDED = "the run is terminated"
NOT_BEGUN = "the slave is not initialized"
NOT_POSITIVE = "the step must be a positive time"
LAST_ENDED = "the last step ended at t = %s s"
BEYOND = "the experiment stops at t = %s s"
NOT_FINITE = "%s = %s: must be a finite number in %s"
PREFERRED = "preferred communication step = %.6g s"
COARSE = (
    "communication step = %s s, the record's is %.6g s: the motion is followed sample by sample, but the outputs show "
    "it at the communication points only"
)

# the coupling: counted in steps (alternation.py), of the accelerations of the base
UNSTABLE = (
    "%s changes its sign at every step and grows, to %s %s at t = %s s: the coupling is unstable, and needs a shorter "
    "communication step or a heavier body under the base"
)

TOO_LONG = (
    "communication step = %s s: with the masses at the base and the springs and dashpots of the joints on it, the "
    "coupling is stable up to steps of about %.2g s"
)

NOT_SET = "the state cannot be set: %s"
