"""Modes, Campbell and veering diagrams, stability, contact scenarios: found, listed, drawn."""
