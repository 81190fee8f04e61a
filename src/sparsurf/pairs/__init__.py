"""Two surfaces: what the patches of one say of the other; arrays in, arrays out."""
