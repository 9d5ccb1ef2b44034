"""The console command `multiblock`: the solver's commands, and `build-fmu`."""

from __future__ import annotations

import sys
from collections.abc import Collection, Sequence

from solver.commands.command_line import OneLineParser, add_commands, program_parser, run_command

OF_FMUS = {
    "build-fmu": ("add_options", "FMU of a column, with a record inside if wanted"),
    "replay": ("add_replay", "run an FMU's reference results and compare"),
}


def command_parser(words: Collection[str] = OF_FMUS) -> OneLineParser:
    """Return the parser of the command `multiblock`: all commands, those of FMUs with options if `words` names them."""
    parser = program_parser("multiblock", "Seismic response of columns of rigid blocks, and FMUs of them.")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    add_commands(commands)
    for name, (adding, text) in OF_FMUS.items():
        command = commands.add_parser(name, help=text)
        if name in words:
            import build_fmu  # the other commands need not import the packaging

            getattr(build_fmu, adding)(command)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line, and return the exit code, 2 for a user's mistake."""
    words = sys.argv[1:] if arguments is None else arguments
    return run_command(command_parser(words), arguments)


if __name__ == "__main__":
    raise SystemExit(main())
