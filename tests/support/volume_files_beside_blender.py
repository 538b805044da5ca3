# SPDX-License-Identifier: GPL-3.0-or-later
"""``check(folder, order)``: writes and reads an OpenVDB file, has Blender read it, and again, in one process."""

from pathlib import Path

import numpy as np


def check_ours(path: Path) -> None:
    """What is written is read bit by bit, and what ends early is an error of ours that went through OpenVDB."""
    import tyndall  # noqa: PLC0415 - in the order that is asked for
    from tyndall.volumes import from_dense, read_vdb, write_vdb  # noqa: PLC0415

    values = np.random.default_rng(1).normal(size=(30, 20, 10)).astype(np.float32)
    written = from_dense("density", values, np.diag([0.5, 0.25, 0.125, 1.0]), first_index=(-7, 3, 0))
    write_vdb(path, [written])
    read = read_vdb(path)["density"]
    assert (read.leaf_values == written.leaf_values).all()
    assert (read.local_from_index == written.local_from_index).all()
    broken = path.with_name("broken.vdb")
    broken.write_bytes(path.read_bytes()[:-200])
    message = ""
    try:
        read_vdb(broken)
    except tyndall.IoError as error:
        message = str(error)
    assert "broken.vdb" in message


def check_blenders(path: Path) -> None:
    """Blender finds our grid in it."""
    import bpy  # noqa: PLC0415 - in the order that is asked for

    volume = bpy.data.volumes.new("Volume")
    volume.filepath = str(path)
    assert volume.grids.load()
    assert volume.grids["density"].matrix_object[0][0] == 0.5
    assert volume.grids["density"].load()


def check(folder: str, ours_comes: str) -> None:
    """ours_comes: "first" or "last"; the one that comes first comes again."""
    path = Path(folder) / "fog.vdb"
    if ours_comes == "last":
        import bpy  # noqa: F401, PLC0415
    check_ours(path)
    check_blenders(path)
    check_ours(path.with_name("again.vdb"))
    print("volume files: agree")
