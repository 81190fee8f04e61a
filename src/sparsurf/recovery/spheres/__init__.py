"""The surface from the spheres that its dots lie on: `votes`, then `atoms`, then `rebuilding`."""
