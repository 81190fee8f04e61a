"""Pictures and pages of one surface, or of one molecule in many frames."""
