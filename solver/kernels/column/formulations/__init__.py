"""The equations of motion: accelerations from coordinates, rates and the motion of the base."""
