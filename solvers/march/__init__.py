"""Time integration of a contact problem (the march), and recording of its results."""
