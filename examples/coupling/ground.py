"""The motion of the ground from a record inside the FMU, for masters that know no tables.

Accelerations with straight lines between the samples, zero before and after; and the slope of each that leads to its
value one communication step further on.
"""

from .law import NOT_NEGATIVE, Port, parameter, port_output

TITLE = "ground"
ABOUT = "Acceleration of the ground from a record"
PORTS = (
    port_output("ground.ax", "m/s2", "Acceleration of the ground, horizontal"),
    port_output("ground.az", "m/s2", "Acceleration of the ground, vertical, positive up"),
    port_output("ground.jx", "m/s3", "Slope of ground.ax within the next step"),
    port_output("ground.jz", "m/s3", "Slope of ground.az within the next step"),
    port_output("pga", "m/s2", "Largest |ax| of the record"),
    Port("record", "parameter", "", "Name of the record inside; empty: none", ""),
    parameter("scale", "", "Factor on the record's accelerations", 1.0),
    parameter("step", "s", "Communication step that the slopes are for; 0: as long as the last one", 0.0, NOT_NEGATIVE),
)
