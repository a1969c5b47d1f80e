"""Modes, Campbell and veering diagrams, stability and contact scenarios."""
