"""Sites: places on surfaces with numbers, by which the same site is found on another surface."""
