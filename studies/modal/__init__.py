"""What `modes`, `veering`, `campbell` and `stability` compute."""
