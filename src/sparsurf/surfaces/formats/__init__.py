"""File formats of surfaces, one module each; `read_surface` lists them."""
