"""Pictures of the response of a column, as `models/pictures.py` asks for them."""

from .drawings import plot_model
from .film import film
from .plots import plot_response

__all__ = ["film", "plot_model", "plot_response"]
