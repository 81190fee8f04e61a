"""The version of the library, for whoever writes it into a file."""

__version__ = "6.0.0"
