#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Copies the fixtures that may lie in the repository from a folder of parity fixtures to Testing/Data/Parity.

Those are computed from random weights. Left out of the copies is what the tests do not read, and gradients and
parameters of training steps are rounded from float64 to float32, ten times finer than their limits.

    trim_fixtures.py FOLDER [--check]

--check compares instead of writing, and fails when a copy is not what this script would write.
"""

import argparse
import json
import pathlib
import struct
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
TARGET = ROOT / "Testing" / "Data" / "Parity"
FIXTURES = [
    "poissonnet/random_A_ours_w32",
    "poissonnet/random_C_norm_nomod",
    "poissonnet/random_D_vertices",
    "dgts/generator_random",
    "dgts/inference__dragknob",
    "dgts/discriminator_random",
    "dgts/train_step",
    "dgts/gt_losses",
    "fieldconv/fieldconv_eight",
]


def is_read_of_dgts(name):
    """Levels that the fixture runs, and of their numbers those that the tests compare."""
    if name.startswith("levels."):
        return name.split(".")[1] in {"0", "1", "2"}
    if name.startswith(("out.", "s")):
        step, what = name.split(".", 1)
        return step != "out" and (
            what in {"vs", "vs_in", "faces", "gfmm", "features", "vertex_displacement"} or name == "s0.first_conv"
        )
    return name != "in.noise2"


def is_read(fixture, name):
    """True for the tensors that the tests use."""
    if fixture in {"dgts/train_step", "dgts/gt_losses"}:
        # what float32 gives is not compared
        return "f32." not in name and name not in {
            "ref.edge_mean_std", "source.n_edges", "source.vertex2vertex", "source.vs", "target.vs", "real.level1_faces"
        } and not name.endswith("norms")
    if fixture.startswith("fieldconv/"):
        return name == "in.x" or name.startswith("pre.") or name.startswith("conv") and not name.endswith(".out")
    if fixture.startswith("dgts/"):
        return is_read_of_dgts(name)
    if name == "mesh.vertices" or ".head." in name and name.startswith("ref."):
        return False
    if name.startswith("ref.block"):
        step = name.split(".", 2)[2]
        first = name.startswith("ref.block0.")
        return step == "out" or first and step in {"grads_in", "x_face", "mod_re", "mod_im", "grads", "rhs", "u"}
    return True


def read(path):
    data = path.read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + length])
    metadata = header.pop("__metadata__", {})
    tensors = {}
    for name, entry in header.items():
        begin, end = entry["data_offsets"]
        tensors[name] = (entry["dtype"], entry["shape"], data[8 + length + begin : 8 + length + end])
    return tensors, metadata


def rounded(name, tensor):
    kind, shape, data = tensor
    if kind == "F64" and any(
        part in name for part in (".grad.", ".after3.", ".grad_penalty_only.", ".after_step.")
    ):
        count = len(data) // 8
        return "F32", shape, struct.pack(f"<{count}f", *struct.unpack(f"<{count}d", data))
    return tensor


def serialize(tensors, metadata):
    """As the library's writer does it: large elements first, then by name; header padded to 8 bytes."""
    sizes = {"F64": 8, "I64": 8, "F32": 4, "I32": 4}
    header = {"__metadata__": dict(sorted(metadata.items()))}
    parts = []
    end = 0
    for name in sorted(tensors, key=lambda n: (-sizes[tensors[n][0]], n)):
        kind, shape, data = tensors[name]
        header[name] = {"dtype": kind, "shape": shape, "data_offsets": [end, end + len(data)]}
        parts.append(data)
        end += len(data)
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 8)
    return struct.pack("<Q", len(text)) + text + b"".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    parser.add_argument("folder", type=pathlib.Path, help="the whole fixtures")
    arguments = parser.parse_args()
    check = arguments.check
    if not arguments.folder.is_dir():
        parser.error(f"{arguments.folder} is no folder")
    different = 0
    for fixture in FIXTURES:
        tensors, metadata = read(arguments.folder / f"{fixture}.safetensors")
        data = serialize({n: rounded(n, t) for n, t in tensors.items() if is_read(fixture, n)}, metadata)
        target = TARGET / f"{fixture}.safetensors"
        if check:
            same = target.is_file() and target.read_bytes() == data
            different += not same
            print(f"{fixture}: {'as it should be' if same else 'DIFFERENT'}")
        else:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
            print(f"{target.relative_to(ROOT)}: {len(data)} bytes")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
