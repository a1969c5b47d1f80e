"""What a bladed disk is made of: the standard disk, a sketch, a mesh, as one beam model."""
