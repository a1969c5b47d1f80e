"""Runs and sweeps as HTML pages that need no network."""
