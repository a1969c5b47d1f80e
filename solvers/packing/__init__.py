"""Conversion of a contact problem to the arrays of the compiled kernel.

Arrays are padded to whole registers; the modes of a cyclic body are arranged by harmonic.
"""
