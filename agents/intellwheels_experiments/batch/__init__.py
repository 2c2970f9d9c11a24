"""Many runs of an experiment: workers, stored results, statistics and the report."""
