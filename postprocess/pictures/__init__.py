"""Stages, runs and modes drawn with pyvista: stills, sheets, films and web pages."""
