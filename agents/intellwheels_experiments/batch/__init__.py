"""Many runs of an experiment: workers, stored runs, statistics and the report."""
