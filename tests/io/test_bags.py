"""Bags: which file of a folder is read, and the errors of other folders."""

from pathlib import Path

import pytest

from hypertuna.errors import InputError
from hypertuna.io.bags import read_bag


@pytest.mark.parametrize(
    ("names", "sentence"),
    [
        ([], r"bag must hold one \.mcap or \.db3 file, but is 0 of them: give the path of one of its files"),
        (["a.mcap", "b.db3"], r"bag must hold one \.mcap or \.db3 file, but is 2 of them"),
        (["a.db3", "metadata.yaml"], r"a\.db3 must be a bag of ROS 2 or a log \(MCAP\), but is something else"),
        (["metadata.yaml", "z.mcap"], r"z\.mcap must be a bag of ROS 2 or a log \(MCAP\), but is something else"),
    ],
)
def test_a_folder_has_one_file_of_messages(tmp_path: Path, names: list[str], sentence: str) -> None:
    (tmp_path / "bag").mkdir()
    for name in names:
        (tmp_path / "bag" / name).write_text("none")
    with pytest.raises(InputError, match=sentence):
        read_bag(tmp_path / "bag")


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"#ROSBAG V2.0\n", "a bag of ROS 1: convert it: rosbags-convert"),
        (b"\x28\xb5\x2f\xfd", r"a compressed file: give a \.mcap or \.db3 file, unpacked"),
        (b"", r"something else: give a \.mcap or \.db3 file, unpacked"),
    ],
)
def test_another_file_is_named_by_its_first_bytes(tmp_path: Path, content: bytes, sentence: str) -> None:
    (tmp_path / "a.bag").write_bytes(content)
    with pytest.raises(InputError, match=f"must be a bag of ROS 2 or a log .MCAP., but is {sentence}"):
        read_bag(tmp_path / "a.bag")
