"""What a person calls: Python functions on arrays, and the command line."""
