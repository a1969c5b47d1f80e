"""Tables of a case file: definition, reading, validation, writing and plausibility."""
