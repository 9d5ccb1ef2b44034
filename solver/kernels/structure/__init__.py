"""Rigid blocks in space, any graph of them: joints of six components, ties, stepping (theory.md section 13)."""
