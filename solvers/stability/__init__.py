"""Growth rates, unstable zones, Floquet analysis, coincidence and veering."""
