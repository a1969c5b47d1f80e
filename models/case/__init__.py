"""The tables of a case file, how they are read, checked, written and made plausible."""
