"""bladewhirl."""
