"""Convergence studies: marches of one case with several time steps and numbers of modes."""
