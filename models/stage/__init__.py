"""The reduced stage with its loads, and the contact problem for time integration."""
