"""Blades, sectors and wheels given by their matrices, reduced to their contact nodes."""
