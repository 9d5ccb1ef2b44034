"""Pictures and films of models, runs and records."""
