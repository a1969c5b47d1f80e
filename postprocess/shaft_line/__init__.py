"""Figures of a shaft line."""
