"""Choice of the dots that a subset keeps."""

from sparsurf.sampling import adaptive as adaptive  # registers its sampler
