"""Known answers, recomputed here: `bladewhirl verify`; a module a subject."""
