"""Select subsets of the dots of a surface."""
