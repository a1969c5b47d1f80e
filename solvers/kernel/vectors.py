"""Eight doubles at a time in compiled code.

numba leaves it to the compiler to find vector registers in plain loops. In a step of a
microsecond that costs more than half of the time: the compiler must guard each loop against
arrays that overlap, keeps sums in memory for the same reason, and leaves remainders to scalar
code. The functions here name the registers: ``load`` and ``store`` move LANES consecutive doubles
of an array, ``fma`` and ``total`` work on them. Machines with narrower registers get the same
results, the compiler splits each operation. Arrays must be padded to whole registers; nothing is
checked.
"""

# The code generators below speak to untyped interfaces of numba and llvmlite throughout.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator, misc"

from __future__ import annotations

import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_builtin,
    lower_getattr,
    lower_getattr_generic,
    models,
    register_model,
    type_callable,
)

LANES = 8
"""Doubles in the widest common vector register."""

HALF = LANES // 2
"""Doubles of the narrower kind of register, for short vectors (``load_half``)."""


class _LanesType(types.Type):
    def __init__(self, width):
        self.width = width
        super().__init__(name=f"lanes{width}")


@register_model(_LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, _vector(kind.width))


def _vector(width):
    return ir.VectorType(ir.DoubleType(), width)


_FULL, _HALF = _LanesType(LANES), _LanesType(HALF)


class _BareType(types.Type):
    """A vector or matrix."""

    def __init__(self, dtype, ndim):
        self.dtype, self.ndim = dtype, ndim
        self.members = [
            ("data", types.CPointer(dtype)),
            *((f"size{axis}", types.intp) for axis in range(ndim)),
        ]
        super().__init__(name=f"bare{ndim}({dtype})")


class _BundleType(types.Type):
    """A named tuple."""

    def __init__(self, kind):
        self.members = [
            (name, _bare_type(item)) for name, item in zip(kind.fields, kind, strict=True)
        ]
        super().__init__(name=f"bundle({', '.join(str(item) for _, item in self.members)})")


@register_model(_BareType)
@register_model(_BundleType)
class _BareModel(models.StructModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, kind.members)

    def traverse(self, builder):
        """Nothing that references are counted to."""
        return []


def _bare_type(kind):
    if isinstance(kind, types.BaseNamedTuple):
        return _BundleType(kind)
    return _BareType(kind.dtype, kind.ndim) if isinstance(kind, types.Array) else kind


def _bare_value(context, builder, kind, value):
    if isinstance(kind, types.BaseNamedTuple):
        items = {
            name: _bare_value(context, builder, item, builder.extract_value(value, i))
            for i, (name, item) in enumerate(zip(kind.fields, kind, strict=True))
        }
    elif isinstance(kind, types.Array):
        view = context.make_array(kind)(context, builder, value)
        sizes = cgutils.unpack_tuple(builder, view.shape)
        items = {"data": view.data} | {f"size{axis}": size for axis, size in enumerate(sizes)}
    else:
        return value
    out = cgutils.create_struct_proxy(_bare_type(kind))(context, builder)
    for name, item in items.items():
        setattr(out, name, item)
    return out._getvalue()


@intrinsic
def bare(typing_context, bundle):
    """A named tuple with its C-contiguous vectors and matrices as bare addresses and sizes.

    They are indexed as arrays are, by indices that are not negative. As an argument each takes two
    or three words where an array takes seven or ten, and nothing counts references to it (a count
    is an atomic operation, some ten of which cost as much as a product): the caller must keep
    the arrays alive. Tuples within tuples are seen to; anything else stays as it is.
    """

    def generate(context, builder, signature, arguments):
        return _bare_value(context, builder, signature.args[0], arguments[0])

    return _bare_type(bundle)(bundle), generate


@infer_getattr
class _BundleAttributes(AttributeTemplate):
    key = _BundleType

    def generic_resolve(self, kind, name):
        return dict(kind.members).get(name)


@lower_getattr_generic(_BundleType)
def _lower_member(context, builder, kind, bundle, name):
    return builder.extract_value(bundle, [*dict(kind.members)].index(name))


def _item(builder, kind, array, indices):
    """Pointer to an item."""
    place = indices[-1]
    if kind.ndim == 2:
        columns = builder.extract_value(array, 2)
        place = builder.add(builder.mul(indices[0], columns), place)
    return builder.gep(builder.extract_value(array, 0), [place])


def _index_type(kind):
    return types.intp if kind.ndim == 1 else types.UniTuple(types.intp, 2)


def _indices(builder, kind, index):
    return [index] if kind.ndim == 1 else cgutils.unpack_tuple(builder, index)


@type_callable(operator.getitem)
def _type_getitem(context):
    def typer(array, index):
        if isinstance(array, _BareType):
            return array.dtype(array, _index_type(array))
        return None

    return typer


@type_callable(operator.setitem)
def _type_setitem(context):
    def typer(array, index, value):
        if isinstance(array, _BareType):
            return types.void(array, _index_type(array), array.dtype)
        return None

    return typer


@type_callable(len)
def _type_len(context):
    def typer(array):
        return types.intp if isinstance(array, _BareType) else None

    return typer


@lower_builtin(operator.getitem, _BareType, types.Any)
def _lower_getitem(context, builder, signature, arguments):
    kind, (array, index) = signature.args[0], arguments
    return builder.load(_item(builder, kind, array, _indices(builder, kind, index)))


@lower_builtin(operator.setitem, _BareType, types.Any, types.Any)
def _lower_setitem(context, builder, signature, arguments):
    kind, (array, index, value) = signature.args[0], arguments
    builder.store(value, _item(builder, kind, array, _indices(builder, kind, index)))
    return context.get_dummy_value()


@lower_builtin(len, _BareType)
def _lower_len(context, builder, signature, arguments):
    return builder.extract_value(arguments[0], 1)


@infer_getattr
class _BareAttributes(AttributeTemplate):
    key = _BareType

    def resolve_shape(self, kind):
        return types.UniTuple(types.intp, kind.ndim)


@lower_getattr(_BareType, "shape")
def _lower_shape(context, builder, kind, array):
    sizes = [builder.extract_value(array, 1 + axis) for axis in range(kind.ndim)]
    return context.make_tuple(builder, types.UniTuple(types.intp, kind.ndim), sizes)


def _address(context, builder, kind, array, indices, width):
    """Pointer to a register's worth of an array from an index on."""
    return builder.bitcast(_item(builder, kind, array, indices), _vector(width).as_pointer())


def _loader(width):
    def generate(context, builder, signature, arguments):
        kind, array, indices = signature.args[0], arguments[0], arguments[1:]
        value = builder.load(_address(context, builder, kind, array, indices, width))
        value.align = 8
        return value

    return generate


def _storer(context, builder, signature, arguments):
    kind, array, indices, value = signature.args[0], arguments[0], arguments[1:-1], arguments[-1]
    place = _address(context, builder, kind, array, indices, signature.args[-1].width)
    builder.store(value, place).align = 8
    return context.get_dummy_value()


def _splatter(width):
    def generate(context, builder, signature, arguments):
        blank = ir.Constant(_vector(width), ir.Undefined)
        first = builder.insert_element(blank, arguments[0], ir.IntType(32)(0))
        everywhere = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
        return builder.shuffle_vector(first, blank, everywhere)

    return generate


@intrinsic
def plain(typing_context, value):
    """An integer literal as any other integer: numba compiles a function anew for each literal."""

    def generate(context, builder, signature, arguments):
        return arguments[0]

    return types.int64(types.int64), generate


@intrinsic
def load(typing_context, array, i):
    """Doubles i .. i + LANES - 1 of a vector."""
    return _FULL(array, types.intp), _loader(LANES)


@intrinsic
def load_row(typing_context, array, row, i):
    """Doubles i .. i + LANES - 1 of a row of a matrix."""
    return _FULL(array, types.intp, types.intp), _loader(LANES)


@intrinsic
def load_half(typing_context, array, i):
    """Doubles i .. i + HALF - 1 of a vector."""
    return _HALF(array, types.intp), _loader(HALF)


@intrinsic
def load_half_row(typing_context, array, row, i):
    """Doubles i .. i + HALF - 1 of a row of a matrix."""
    return _HALF(array, types.intp, types.intp), _loader(HALF)


@intrinsic
def store(typing_context, array, i, value):
    """Write a register to a vector."""
    return types.void(array, types.intp, value), _storer


@intrinsic
def store_row(typing_context, array, row, i, value):
    """Write a register to a row of a matrix."""
    return types.void(array, types.intp, types.intp, value), _storer


@intrinsic
def splat(typing_context, value):
    """The same double in all LANES lanes."""
    return _FULL(types.float64), _splatter(LANES)


@intrinsic
def splat_half(typing_context, value):
    """The same double in HALF lanes."""
    return _HALF(types.float64), _splatter(HALF)


@intrinsic
def fma(typing_context, a, b, c):
    """a * b + c."""

    def generate(context, builder, signature, arguments):
        product = builder.fmul(arguments[0], arguments[1], flags=("contract",))
        return builder.fadd(product, arguments[2], flags=("contract",))

    return a(a, b, c), generate


def _arithmetic(instruction):
    """An operation on two registers, lane by lane."""

    @intrinsic
    def operation(typing_context, a, b):
        def generate(context, builder, signature, arguments):
            return getattr(builder, instruction)(*arguments)

        return a(a, b), generate

    return operation


add, sub, mul = _arithmetic("fadd"), _arithmetic("fsub"), _arithmetic("fmul")


@intrinsic
def total(typing_context, a):
    """Sum of the lanes."""

    def generate(context, builder, signature, arguments):
        value, whole = arguments[0], signature.args[0].width
        width = whole
        while width > 1:
            width //= 2
            order = [*range(width, 2 * width), *([0] * (whole - width))]
            mask = ir.Constant(ir.VectorType(ir.IntType(32), whole), order)
            value = builder.fadd(value, builder.shuffle_vector(value, value, mask))
        return builder.extract_element(value, ir.IntType(32)(0))

    return types.float64(a), generate


def _shuffled(builder, a, b, order):
    return builder.shuffle_vector(
        a, b, ir.Constant(ir.VectorType(ir.IntType(32), len(order)), order)
    )


@intrinsic
def totals(typing_context, a, b, c, d):
    """Sums of the lanes of four half registers, one a lane."""

    def generate(context, builder, signature, arguments):
        first, second, third, fourth = arguments
        pairs = [
            builder.fadd(
                _shuffled(builder, x, y, [0, 4, 2, 6]), _shuffled(builder, x, y, [1, 5, 3, 7])
            )
            for x, y in ((first, second), (third, fourth))
        ]
        low = _shuffled(builder, pairs[0], pairs[1], [0, 1, 4, 5])
        return builder.fadd(low, _shuffled(builder, pairs[0], pairs[1], [2, 3, 6, 7]))

    return _HALF(_HALF, _HALF, _HALF, _HALF), generate


@intrinsic
def reverse(typing_context, a):
    """The lanes in reverse order."""

    def generate(context, builder, signature, arguments):
        order = [*range(signature.args[0].width)][::-1]
        return _shuffled(builder, arguments[0], arguments[0], order)

    return a(a), generate
