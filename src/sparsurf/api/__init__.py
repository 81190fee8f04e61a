"""The functions for users, by subject: they take what users hold, check it, and call the packages that compute."""
