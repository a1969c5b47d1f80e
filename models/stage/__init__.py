"""The reduced stage with its loads, as the contact problem that is marched."""
