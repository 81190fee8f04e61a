"""The command line: each command parses, calls a function of `sparsurf.api`, and writes."""
