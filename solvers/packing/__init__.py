"""A contact problem laid out for the kernel: modes in whole registers, by harmonic where cyclic."""
