"""Figures of modes, Campbell and veering diagrams, and stability charts."""
