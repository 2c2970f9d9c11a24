"""Experiments: run scenes as processes, watch, judge and report them, and test agents in simulated worlds."""
