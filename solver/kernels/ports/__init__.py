"""The columns with ports: points of blocks at which loads act, and whose motion is an output (theory.md section 16)."""
