"""Springs between bladed disk and casing that represent frame and bearings (Eqs 4-10).

`equations` has the equations of motion of coupled modes; `springs` has modes with one nodal
diameter each. `stage_modes` takes the modes from finite element models with cyclic symmetry,
`stage_waves` from any other models.
"""
