"""Modal studies of a shaft line."""
