"""Fields: a number at each dot of a surface, from the molecule that it was made of."""
