"""Pictures and pages of one surface."""
