"""Rules between a superelement, or beams, and the other tables of a case."""

from collections.abc import Iterator

from bladewhirl.models.case.blade_loss import BladeLoss
from bladewhirl.models.case.superelement import SOURCE, SuperelementTable
from bladewhirl.models.case.tables import Tables
from bladewhirl.models.inputs.table import Inconsistency, path_of, value_at
from bladewhirl.models.structure.rotating import Rotating

RULES: tuple[tuple[str, tuple[object, ...], str], ...] = (
    (
        "contact.sliding",
        ("full", "permanent"),
        "a contact node also slides along the axis, where a signed speed has no meaning",
    ),
    (
        "contact.foreshortening",
        (False,),
        "linear matrices do not say by how much a tip draws back when its blade bends",
    ),
    ("shaft.fuse_force", (None,), "a support that fuses is a bearing of a disk of beams"),
    ("reduction.modes", ("all",), "the modes of a file are chosen when the file is made"),
)
"""Keys that a superelement restricts: the values that it allows, and the reason."""

OF_SPRINGS: tuple[tuple[str, tuple[object, ...], str], ...] = (
    ("coupling.modes", ("all",), "the modes of a file have no names"),
    ("coupling.amplitude", ("physical",), "the springs act on the contact nodes"),
)
"""Keys that a superelement restricts if springs act between it and the casing."""


def superelement_faults(case: Tables) -> Iterator[Inconsistency]:
    """Yield contradictions between a superelement, or its absence, and other tables of a case; and
    what a rigid wall does not allow."""
    if case.casing.type == "rigid":
        yield from _rigid_faults(case)
    if case.bladed_disk.superelement is None:
        if case.casing.radius is not None:
            expected = f"not allowed without {SOURCE}: the radius follows from the tips"
            yield Inconsistency("casing.radius", expected, (SOURCE,))
        for key in ("slope", "contour"):
            if getattr(case.casing, key):
                expected = f"not allowed without {SOURCE}: tips of beams do not move along the axis"
                yield Inconsistency(f"casing.{key}", expected, (SOURCE,))
        if case.contact.sliding == "full":
            for key, given in (
                ("casing.coating", case.casing.coating is not None),
                ("contact.foreshortening", case.contact.foreshortening),
            ):
                if given:
                    expected = (
                        f'"permanent" or "signed" with {key} of beams, whose forces have a given'
                        " direction of sliding"
                    )
                    yield Inconsistency("contact.sliding", expected, (key,))
        for key, load in case.excitations.items():
            if getattr(load, "points", ()):
                expected = f"not allowed without {SOURCE}; give position"
                yield Inconsistency(f"{key}.points", expected, (SOURCE,))
        worn = None if case.casing.coating is None else case.casing.coating.profile
        if worn is not None and worn.tracks:
            expected = f"points without axial positions, or a {SOURCE}"
            yield Inconsistency("casing.coating.profile", expected, (SOURCE,))
        return
    forbidden = f"not allowed together with {SOURCE}; remove this key"
    if case.sketch is not None:
        yield Inconsistency("sketch", forbidden, (SOURCE,))
    table = case.bladed_disk.superelement
    if case.blade_loss is not None:
        yield from _loss_faults(case.blade_loss, table.kind)
    for key, load in case.excitations.items():
        if load.acts_on == "centre" and table.kind != "wheel":
            expected = f'another excitation, or {SOURCE}.kind = "wheel", which has a centre'
            yield Inconsistency(f"{key}.type", expected, (SOURCE,))
        elif load.acts_on == "centre" and table.part.centre_dofs is None:
            expected = "another excitation, or a superelement with centre_dofs"
            yield Inconsistency(f"{key}.type", expected, (SOURCE,))
        elif getattr(load, "position", "tip") != "tip":
            expected = f'"tip" with {SOURCE}, whose matrices have no centre line; give points'
            yield Inconsistency(f"{key}.position", expected, (SOURCE,))
        elif (points := getattr(load, "points", ())) and max(points) >= table.part.point_count:
            expected = f"numbers of points of the file, below {table.part.point_count}"
            yield Inconsistency(f"{key}.points", expected, (SOURCE,))
    for key, allowed, reason in RULES + (OF_SPRINGS if case.coupling.stiffness else ()):
        if value_at(case, path_of(key)) not in allowed:
            texts = " or ".join(f'"{one}"' if isinstance(one, str) else str(one) for one in allowed)
            yield Inconsistency(key, f"{texts} with {SOURCE}: {reason}", (SOURCE,))
    yield from _rotation_faults(case, table)
    moved = [key for key, value in case.initial.model_dump(exclude_defaults=True).items() if value]
    for key in moved:
        if key.startswith("centre") and (table.kind != "wheel" or table.part.centre_dofs is None):
            expected = f'motion of the tips only, or {SOURCE}.kind = "wheel" with centre_dofs'
            yield Inconsistency(f"initial.{key}", expected, (SOURCE,))
    on_blades = [
        f'{key}.type = "{load.type}"'
        for key, load in case.excitations.items()
        if load.acts_on == "blades"
    ]
    springs = ["coupling.stiffness"] if case.coupling.stiffness else []
    needed = [*(f"initial.{key}" for key in moved), *on_blades, *springs]
    if table.kind == "wheel" and table.copies == 1 and needed:
        expected = f"the number of blades of the wheel, for {needed[0]}"
        yield Inconsistency(f"{SOURCE}.copies", expected)


def _loss_faults(loss: BladeLoss, kind: str) -> Iterator[Inconsistency]:
    """Yield errors for the loss of a blade of a superelement."""
    if kind != "blade":
        expected = (
            f'no [blade_loss], or {SOURCE}.kind = "blade": a {kind} is reduced as one body, and its'
            " file does not say which part of its mass is that of a blade"
        )
        yield Inconsistency("blade_loss.blade", expected, (SOURCE,))
    elif loss.share:
        expected = (
            f"0 with {SOURCE}, whose file does not say which of its coordinates lie beyond a"
            " fracture: a blade is lost as a whole"
        )
        yield Inconsistency("blade_loss.from", expected, (SOURCE,))


def _rigid_faults(case: Tables) -> Iterator[Inconsistency]:
    """Yield loads and springs that act on a flexible casing."""
    for key, load in case.excitations.items():
        if load.acts_on == "casing":
            expected = 'another excitation, or casing.type = "ring"'
            yield Inconsistency(f"{key}.type", expected, ("casing.type",))
    if case.coupling.stiffness:
        expected = '0, or casing.type = "ring", whose modes the springs move'
        yield Inconsistency("coupling.stiffness", expected, ("casing.type",))


def _rotation_faults(case: Tables, table: SuperelementTable) -> Iterator[Inconsistency]:
    """Yield errors for rotation effects whose matrices the file lacks."""
    effects, part = case.rotation.effects, table.part
    for key, without, needed in (
        ("stiffness_speed", "tension stiffens no blade and the rotation softens none", effects),
        ("gyroscopic", "there are no Coriolis forces", effects == "full"),
    ):
        if needed not in ("none", False) and getattr(part, key) is None:
            expected = f'"none", or a file with {key}, without which {without}'
            yield Inconsistency("rotation.effects", expected, (SOURCE,))
    drive = case.march.drive
    if drive is not None and effects != "none":
        expected = (
            '"none" with march.drive: a file does not give the moment of inertia, which'
            " displacements change"
        )
        yield Inconsistency("rotation.effects", expected, (SOURCE, "march.drive"))
    if drive is not None and drive.inertia == 0.0:
        expected = f"the moment of inertia of all that turns: {SOURCE} does not give its own"
        yield Inconsistency("march.drive.inertia", expected, (SOURCE,))
    if case.march.varies and effects == "none" and part.gyroscopic is not None:
        expected = (
            '"full" with a speed that varies, or a file without gyroscopic, whose Coriolis forces'
            " would be those of one speed"
        )
        yield Inconsistency("rotation.effects", expected, (SOURCE, "march"))
    if case.march.varies and effects == "full" and part.euler_load is None:
        expected = (
            f'"none" with a speed that varies, or a file with {" and ".join(Rotating.LOADS)}, which'
            " change the length of the blade with the speed; mesh3d writes them"
        )
        yield Inconsistency("rotation.effects", expected, (SOURCE, "march"))
    if case.march.varies and effects == "full" and table.kind == "sector":
        mistuning = case.bladed_disk.mistuning
        if mistuning.is_given(table.copies):
            expected = "no mistuning: the modes of sectors that differ are those of one speed"
            yield Inconsistency("bladed_disk.mistuning", expected, (SOURCE, "march"))
    if case.rotation.clearance == "cold":
        expected = (
            '"hot": the file does not give the static growth of the contact nodes by rotation'
        )
        yield Inconsistency("rotation.clearance", expected, (SOURCE,))
