"""Words of the user and answers to them: quantities with units, tables, names of modes, errors."""
