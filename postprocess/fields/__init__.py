"""Results opened, and displacements, strains and sections recovered from them."""
