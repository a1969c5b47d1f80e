"""What one run says: orbits, spectra, energies, contact, regime, summary."""
