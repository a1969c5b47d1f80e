"""Problems with known answers, recomputed by `bladewhirl verify`; each subject has a module."""
