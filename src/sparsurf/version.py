"""The version of the library, for whoever writes it into a file."""

__version__ = "7.0.0"
