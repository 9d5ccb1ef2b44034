"""The console command `multiblock`: the solver's commands, and `build-fmu`."""

from __future__ import annotations

from collections.abc import Sequence

import build_fmu
from solver.commands.command_line import OneLineParser, add_commands, program_parser, run_command


def command_parser() -> OneLineParser:
    """Return the parser of the command `multiblock`, with all commands."""
    parser = program_parser("multiblock", "Seismic response of columns of rigid blocks, and FMUs of them.")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    add_commands(commands)
    build_fmu.add_options(commands.add_parser("build-fmu", help="FMU of a column, with a record inside if wanted"))
    build_fmu.add_replay(commands.add_parser("replay", help="run an FMU's reference results and compare"))
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line, and return the exit code, 2 for a user's mistake."""
    return run_command(command_parser(), arguments)


if __name__ == "__main__":
    raise SystemExit(main())
