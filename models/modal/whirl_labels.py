"""Families of whirling modes: those of their branches at rest."""

from __future__ import annotations

import numpy as np

from bladewhirl.models.elements.cyclic import NO_COLUMN
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.modal.labels import LabelledModes, labelled_modes
from bladewhirl.models.rotation.whirl_modes import WhirlModes


def whirl_families(
    structure: Structure, modes: WhirlModes, reference: tuple[int, int]
) -> tuple[str, ...]:
    """Family of each whirling mode of a bladed disk.

    Over the speed, waves of one nodal diameter do not cross where sectors are alike, so their rank
    says which family they are of at rest; without symmetry they belong to the family at rest that
    holds most of them.

    Args:
        structure: that turns.
        modes: of it.
        reference: see `labelled_modes`.
    """
    at_rest = labelled_modes(structure.at_rest or structure, reference, "bladed-disk")
    if modes.rank[:1] == NO_COLUMN:
        return _by_overlap(structure, modes, at_rest)
    one = at_rest.one_a_pair()
    names = {
        int(k): [at_rest.family[i] for i in one[at_rest.nodal_diameter[one] == k]]
        for k in np.unique(modes.nodal_diameter)
    }
    ranked = zip(modes.nodal_diameter.tolist(), modes.rank.tolist(), strict=True)
    return tuple(names[k][rank] for k, rank in ranked)


def _by_overlap(structure: Structure, modes: WhirlModes, at_rest: LabelledModes) -> tuple[str, ...]:
    names = list(dict.fromkeys(at_rest.family))
    every = np.arange(at_rest.count)
    impulse = structure.mass @ modes.fields(np.arange(modes.count))
    parts = np.abs(at_rest.fields(every).T @ impulse) ** 2
    shares = np.zeros((len(names), modes.count))
    np.add.at(shares, [names.index(family) for family in at_rest.family], parts)
    return tuple(names[i] for i in shares.argmax(axis=0))
