"""Cases, finite element models, reduction, and the reduced stage for time integration."""
