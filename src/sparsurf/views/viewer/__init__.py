"""The page of the dots of one surface: to turn, to sample, to pick dots from. It needs no network."""
