"""Springs between bladed disk and casing that stand for frame and bearings (Eqs 4-10)."""
