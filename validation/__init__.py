"""The model compared with measurements, closed forms and other programs: run `python -m validation --help`."""
