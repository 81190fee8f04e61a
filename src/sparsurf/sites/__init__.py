"""Sites: places on a surface with descriptors, which are searched for on other surfaces."""
