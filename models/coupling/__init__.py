"""Springs between bladed disk and casing that represent frame and bearings (Eqs 4-10).

`equations` has the equations of motion of coupled modes, and `springs` these equations if every
mode has a single nodal diameter k. `stage_modes` takes such modes from finite element models with
cyclic symmetry, `stage_waves` takes modes with several nodal diameters from other models.
"""
