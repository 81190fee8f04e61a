"""Which dots are kept."""

from sparsurf.sampling import adaptive as adaptive  # enters its sampler
