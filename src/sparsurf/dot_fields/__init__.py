"""Fields: a number at each dot of a surface, computed from the molecule."""
