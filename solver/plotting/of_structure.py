"""Pictures of responses, modes and push-overs of structures, as `models/pictures.py` asks for them."""

from .structure_statics import plot_modes, plot_push_over
from .structures import film, plot_model, plot_plan, plot_response

__all__ = ["film", "plot_model", "plot_modes", "plot_plan", "plot_push_over", "plot_response"]
