"""How well a subset describes its surface, and which subset is enough."""
