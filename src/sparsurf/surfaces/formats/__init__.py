"""Files of surfaces: a module for each format, all of them named in `read_surface`."""
