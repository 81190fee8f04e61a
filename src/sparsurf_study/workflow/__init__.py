"""What the Snakefile and its scripts ask for: jobs and their logs, versions of the code, the end of a run."""
