"""What the Snakefile and its scripts ask for: config, files, digests, jobs."""
