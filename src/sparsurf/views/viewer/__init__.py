"""A surface as one page of HTML that needs no network: to turn, to sample, to pick dots from."""
