"""Solvers on arrays: the contact march, stability, coincidence, veering."""
