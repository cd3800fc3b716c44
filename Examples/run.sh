#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
#
# From nothing to pictures: installs what is missing (Debian 12, as root or with sudo), builds the library, renders the
# gallery, takes a scan of a brain and one of a femur to meshes with random fields, and lets trained models generate
# signals, poses and textures.
#
#   Examples/run.sh [mesh]
#
# mesh: a surface to use in place of the armadillo (STL, PLY, OBJ, OFF or VTP).
# Environment: JOBS (parallel compilations, default the number of processors), OUTPUT (default Examples/Output).
set -euo pipefail

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)
jobs=${JOBS:-$(nproc)}
output=$(realpath -m -- "${OUTPUT:-$root/Examples/Output}")
meshes=()
if [ $# -gt 1 ]; then
  echo "usage: $0 [mesh]" >&2
  exit 2
elif [ $# -eq 1 ]; then
  if [ ! -f "$1" ]; then
    echo "$0: no file $1" >&2
    exit 2
  fi
  meshes+=("$(realpath -- "$1")")
fi

bash "$root/Examples/install-dependencies.sh"

cd "$root"
export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER:-ccache}
build=$root/build/examples
cmake --preset default -B "$build" -DSURFACE_SYNTHESIS_TESTING=OFF -DSURFACE_SYNTHESIS_BENCHMARKS=OFF
cmake --build "$build" --parallel "$jobs"

mkdir -p "$output"
export PYTHONPATH=$build/lib/python3${PYTHONPATH:+:$PYTHONPATH}
xvfb-run -a -s "-screen 0 1280x1024x24" \
  /usr/bin/python3 "$root/Examples/Python/gallery.py" --output "$output" "${meshes[@]}"
for pipeline in brain femur; do # from a scan to tetrahedra; an ensemble of shapes
  xvfb-run -a -s "-screen 0 1280x1024x24" \
    /usr/bin/python3 "$root/Examples/Python/medical.py" "$pipeline" --output "$output"
done
xvfb-run -a -s "-screen 0 1280x1024x24" \
  /usr/bin/python3 "$root/Examples/Python/flow_matching.py" --output "$output"
xvfb-run -a -s "-screen 0 1280x1024x24" \
  /usr/bin/python3 "$root/Examples/Python/geometric_textures.py" --output "$output"

echo
echo "The pictures and surfaces are in $output:"
(cd "$output" && find . -type f \( -name '*.png' -o -name '*.vt[pu]' \) | sort | sed 's|^\./|  |')
