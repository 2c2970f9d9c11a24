"""The log of a run: what it holds, how it is run again, sought, cut and traced. Knows no service."""
