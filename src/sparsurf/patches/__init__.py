"""What lies around one dot, and its numbers: arrays in, arrays out."""
