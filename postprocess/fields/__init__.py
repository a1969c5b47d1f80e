"""Open results, and recover displacements, strains and sections from them."""
