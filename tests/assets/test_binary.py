import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.assets.binary import MAX_RUN_TOTAL, BinaryFile, run_members, text_until_nul
from followspot.errors import AssetError

FILE = BinaryFile(bytes(range(16)), "a.bin")


def test_array_views_the_file_read_only() -> None:
    array = FILE.array("<u2", 2, 3, "numbers")
    assert array.tolist() == [0x0302, 0x0504, 0x0706]
    assert not array.flags.writeable
    assert array.base is not None


@pytest.mark.parametrize(
    ("offset", "count"),
    [(-1, 1), (0, -1), (0, 5), (13, 1), (17, 0), (0, 1 << 62), (1 << 62, 1), (16, 1)],
)
def test_array_outside_of_the_file_is_an_asset_error(offset: int, count: int) -> None:
    with pytest.raises(AssetError) as error:
        FILE.array("<u4", offset, count, "numbers")
    assert str(error.value) == (
        f"a.bin: numbers: expected {count} x 4 bytes from offset {offset} on, "
        "found a file of 16 bytes"
    )


def test_array_takes_offsets_as_a_header_holds_them() -> None:
    with pytest.raises(AssetError):  # and not the wrapped-round -2**31, with a warning
        FILE.array("<u4", np.int32(2**31 - 1), np.int32(2**31 - 1), "numbers")  # type: ignore[arg-type]


def test_record_is_one_record() -> None:
    record = FILE.record(np.dtype([("a", "u1"), ("b", "<u2")]), 4, "pair")
    assert record.tolist() == (4, 0x0605)


def test_require_names_the_first_bad_record() -> None:
    values = np.array([[1, 2], [3, 4], [5, 6]])
    with pytest.raises(AssetError) as error:
        FILE.require(values != 4, values, "pairs[{}].key", "no four")
    assert str(error.value) == "a.bin: pairs[1].key: expected no four, found [3, 4]"


def test_require_indices() -> None:
    FILE.require_indices(np.array([0, 1, 2]), 3, "i[{}]")
    FILE.require_indices(np.array([-2, 2]), 3, "i[{}]", lowest=-2)
    FILE.require_indices(np.zeros(0, np.int32), 0, "i[{}]")
    for bad in (-1, 3, -(2**31), 2**31 - 1):
        with pytest.raises(AssetError, match=rf"i\[1\]: .* from 0 to 2, found {bad}"):
            FILE.require_indices(np.array([0, bad], np.int32), 3, "i[{}]")
    with pytest.raises(AssetError, match="expected no index, found 0"):
        FILE.require_indices(np.array([0]), 0, "i[{}]")


@pytest.mark.parametrize(
    "bad", [(-1, 1), (0, -1), (0, 5), (4, 1), (5, 0), (2**31 - 1, 2**31 - 1), (-(2**31), 1)]
)
def test_require_runs(bad: tuple[int, int]) -> None:
    FILE.require_runs(np.array([0, 4, 1]), np.array([4, 0, 2]), 4, "runs[{}]")
    first, length = np.array([(0, 1), bad], np.int32).T
    with pytest.raises(AssetError, match=r"runs\[1\]") as error:
        FILE.require_runs(first, length, 4, "runs[{}]")
    assert error.value.found == f"{list(bad)}"


def test_overlapping_runs_are_bounded_together() -> None:
    first, length = np.zeros(1024, np.int32), np.full(1024, MAX_RUN_TOTAL // 1024)
    FILE.require_runs(first, length, MAX_RUN_TOTAL, "runs[{}]")
    with pytest.raises(AssetError, match="together"):
        FILE.require_runs(first, length + 1, MAX_RUN_TOTAL, "runs[{}]")


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(0, 9)), max_size=8))
def test_run_members(runs: list[tuple[int, int]]) -> None:
    first, length = np.array(runs, np.int32).reshape(-1, 2).T
    expected = [i for start, count in runs for i in range(start, start + count)]
    assert run_members(first, length).tolist() == expected


def test_text_until_nul() -> None:
    assert text_until_nul(b"caf\xe9\0rest") == "caf\u00e9"
    assert text_until_nul(b"") == ""
