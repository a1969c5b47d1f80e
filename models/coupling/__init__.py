"""Springs between bladed disk and casing that represent frame and bearings (Eqs 4-10).

`equations` holds the equations of motion of all coupled modes, `springs` modes with one nodal
diameter each. `stage_modes` and `stage_waves` collect modes of a stage with cyclic symmetry and of
any other one from finite elements.
"""
