"""Complete runs: a single one, one with its check and ensemble, many at once."""
