"""A dense surface from few dots with normals."""
