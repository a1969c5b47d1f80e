"""Parsing and validation of user input: quantities with units, tables, names of modes, errors."""
