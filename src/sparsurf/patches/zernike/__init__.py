"""The image of a patch and its Zernike moments."""
