"""Cross-sections of beams and of the casing's wall."""
