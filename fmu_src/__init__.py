"""The FMI 2.0 co-simulation slave: variables, model description, lifecycle. No numerics."""
