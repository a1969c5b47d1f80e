"""Analyses of one run: orbits, spectra, energies, contact, regime, summary."""
