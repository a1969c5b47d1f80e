"""Motion of the shaft: orbit, whirl, spectra, state space."""
