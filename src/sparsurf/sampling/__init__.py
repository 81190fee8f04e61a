"""Select subsets of the dots of a surface."""

from sparsurf.sampling import adaptive as adaptive  # registers its sampler
