"""The groups of entries: each is typed, optimized and stored as one piece of machine code."""

from typing import NamedTuple

KERNELS = __package__.rpartition(".")[0]


class Group(NamedTuple):
    """A group of entries."""

    module: str  # that defines them, below solver/kernels/
    purpose: str
    seconds: int  # that it takes to make, measured on one core
    beside: str = ""  # what identifies the sources of a module that is elsewhere
    along: tuple[str, ...] = ()  # groups needed with it, which a first need makes at the same time
    is_packaged: bool = True  # False: native FMUs alone have it

    @property
    def whole_module(self) -> str:
        """The name of the module as it is imported."""
        return self.module if self.beside else f"{KERNELS}.{self.module}"


_ALONE = "column", "statics"  # that follow a run before and after its lane
GROUPS = {
    "column": Group("column.api.entries", "columns", 45, along=("statics",)),
    "column_driven": Group("column.api.entries", "columns without Python", 60, is_packaged=False),
    "statics": Group("column.api.entries", "columns at rest", 15),
    "paper": Group("paper.entries", "the paper's columns", 22),
    "paper_lanes": Group("paper.entries", "the paper's columns in lanes", 12),
    "lanes": Group("column.batch.entries", "columns in lanes", 14, along=_ALONE),
    "lanes_round": Group("column.batch.entries", "round columns in lanes", 14, along=_ALONE),
    "lanes_slipping": Group("column.batch.entries", "sliding columns in lanes", 16, along=_ALONE),
    "lanes_round_slipping": Group("column.batch.entries", "round sliding columns in lanes", 17, along=_ALONE),
    "lanes_strips": Group("column.batch.entries", "columns on strips in lanes", 20, along=_ALONE),
    "lanes_rims": Group("column.batch.entries", "columns with rims in lanes", 22, along=_ALONE),
    "structure": Group("structure.entries", "structures", 65),
    "structure_driven": Group("structure.entries", "structures that FMUs drive", 75),
    "structure_lanes": Group("structure.entries", "structures in lanes", 45),
}
