"""Periodic motions of a rub without time integration, their stability, and branches of them."""
