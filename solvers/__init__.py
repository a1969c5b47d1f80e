"""Solvers on arrays: time integration with contact, stability, coincidence, veering."""
