"""Pictures of responses, modes and push-overs of structures, as `models/pictures.py` asks for them."""

from .structure_statics import plot_modes, plot_push_over
from .structures import film, plot_plan, plot_response, plot_structure

__all__ = ["film", "plot_modes", "plot_plan", "plot_push_over", "plot_response", "plot_structure"]
