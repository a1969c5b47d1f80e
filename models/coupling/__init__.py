"""Springs between bladed disk and casing that represent frame and bearings (Eqs 4-10).

`springs` couples modes of one nodal diameter each, which `invariant_frame` makes autonomous;
`waves` couples all others. `stage_modes` and `stage_waves` collect both from finite elements.
"""
