"""Conversion of a contact problem to the arrays of the compiled kernel.

Arrays are padded to whole registers; modes of a cyclic rotor or casing are arranged by harmonic.
"""
