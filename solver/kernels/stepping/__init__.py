"""The one stepping loop and what it is made of."""
