"""The block inside an FMU."""

from collections.abc import Mapping
from typing import Any

from fmu_src.body import Body

from .block import Block, Rocking


class BlockBody(Body, word="block"):
    """Inputs, outputs, verdict and record as of any model in its plane."""

    @classmethod
    def read(cls, data: Mapping[str, Any]) -> "BlockBody":
        """Read the numbers of a block."""
        return cls(Block.from_dict(data))

    def stepper(self, described: Block) -> Rocking:
        """Return the stepper that follows it from call to call."""
        return Rocking(described)
