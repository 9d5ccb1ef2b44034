"""Commands where writing goes wrong, or where two write at once."""

from __future__ import annotations

import sys

import build_fmu
from solver.commands.command_line import main


def simulate(column: str, motion: str, response: str) -> None:
    """Run `python -m solver simulate` where no file can be larger than 5 kB; exits as it does."""
    import resource

    main(["simulate", column, motion])  # compiles what is not yet: that is not what is tried here
    resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))
    sys.exit(main(["simulate", column, motion, "-o", response, "--force"]))


def build_without_machine_code(column: str, output: str) -> None:
    """Run the builder's command without what takes long in it; exits as it does."""
    vars(build_fmu)["libraries"] = lambda *_: {}
    sys.exit(build_fmu.main([column, "-o", output, "--force"]))
