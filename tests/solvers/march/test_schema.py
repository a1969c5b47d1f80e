"""The schema prints itself, and its rows are whole."""

from bladewhirl.solvers.march.schema import RESULT, RESULT_FORMAT, SWEEP, SWEEP_FORMAT, schema_table


def test_a_page_has_a_row_for_every_variable() -> None:
    for file in (RESULT, SWEEP):
        rows = schema_table(file).splitlines()[2:]
        assert [row.split("`")[1] for row in rows] == [*file]
        assert {row.count("|") for row in rows} == {8}


def test_every_row_is_filled_in() -> None:
    for file, newest in ((RESULT, RESULT_FORMAT), (SWEEP, SWEEP_FORMAT)):
        for name, variable in file.items():
            assert variable.long_name
            assert variable.units
            assert 1 <= variable.since <= newest
            assert variable.kind in {"f8", "f4", "i8", "i1", "str"}, name
