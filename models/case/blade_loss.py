"""The `[blade_loss]` table of a case: blades that break off during a march."""

from typing import Annotated, Any

from pydantic import (
    BeforeValidator,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
)

from bladewhirl.models.case.superelement import SuperelementTable
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.table import Table


def _blades(value: Any) -> tuple[int, ...]:
    """Return the numbers of blades of one number or of a list."""
    phrase = "the number of a blade, or a list of numbers, each once"
    given = value if isinstance(value, list | tuple) else (value,)
    found = tuple(fields.converted(fields.count(0), each) for each in given)
    if not found or len(set(found)) < len(found):
        raise fields.expectation(phrase)
    return found


class BladeLoss(Table):
    """Blades that break off at an instant; what remains is marched on."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)

    blade: Annotated[tuple[int, ...], BeforeValidator(_blades)]
    """Number of the blade, or a list of blades that are lost together."""
    time: fields.Time
    """Time of the loss [s], rounded to a time step."""
    share: Annotated[float, fields.number("not negative")] = Field(default=0.0, alias="from")
    """Place of the fracture as a share of the length of the blade from its root, the key `from`: 0
    loses the whole blade. The blade breaks at the nearest node, which stays with the root."""

    damaged: SuperelementTable | None = Field(default=None, examples=['{ file = "damaged.npz" }'])
    """File of the wheel that remains, for a wheel on a shaft line, { file = "damaged.npz" }: its
    matrices on the coordinates of the whole wheel, of which those of lost parts have no mass and no
    stiffness, as mesh3d writes them with lost = GROUP."""

    @model_serializer(mode="wrap")
    def _with_alias(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {"from" if name == "share" else name: each for name, each in serialize(self).items()}

    @property
    def text(self) -> str:
        """The loss in words."""
        several = "s" * (len(self.blade) > 1)
        beyond = f" beyond {100.0 * self.share:.3g} % of the length" if self.share else ""
        numbers = ", ".join(map(str, self.blade))
        return f"blade{several} {numbers} lost at {self.time:.4g} s{beyond}"
