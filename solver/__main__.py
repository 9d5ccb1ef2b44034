"""The entry point of `python -m solver`."""

from .commands.command_line import main

if __name__ == "__main__":
    raise SystemExit(main())
