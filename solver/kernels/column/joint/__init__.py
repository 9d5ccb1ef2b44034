"""The joint: its law, and the regimes in which that law is smooth."""
