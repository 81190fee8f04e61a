"""Tables become sentences and pictures; nothing is computed here."""
