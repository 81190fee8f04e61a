"""Sites: places on a surface with descriptors, by which the same site is found on another surface."""
