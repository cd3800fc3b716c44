#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
#
# From nothing to pictures: installs what is missing (Debian 12, as root or with sudo), then
#   1. builds the library without CGAL, OpenVDB, TetGen and LibTorch, and makes the first picture: four random fields;
#   2. builds the rest of the library, and makes all pictures of Examples/README.md that need no training.
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
export PYTHONPATH=$build/lib/python3${PYTHONPATH:+:$PYTHONPATH}
mkdir -p "$output"

# build <ON or OFF>: with or without the libraries that take most of the time. Both use one build folder: the first part is
# compiled once.
build() {
  local options=(-DSURFACE_SYNTHESIS_TESTING=OFF -DSURFACE_SYNTHESIS_BENCHMARKS=OFF) name
  for name in CGAL OPENVDB TETGEN LEARNING EXAMPLES; do
    options+=("-DSURFACE_SYNTHESIS_$name=$1")
  done
  cmake --preset default -B "$build" "${options[@]}"
  cmake --build "$build" --parallel "$jobs"
}

# example <script> <argument>...: runs an example of Examples/Python.
example() {
  local script=$root/Examples/Python/$1
  shift
  xvfb-run -a -s "-screen 0 1280x1024x24 -noreset" /usr/bin/python3 "$script" "$@" --output "$output"
}

# A folder in which the second part was configured before is not taken back to the first one.
if ! grep -qs '^SURFACE_SYNTHESIS_LEARNING:BOOL=ON' "$build/CMakeCache.txt"; then
  started=$SECONDS
  build OFF
  seconds=$((SECONDS - started))
  example gallery.py --only seeds "${meshes[@]}"
  echo
  echo "The first picture, after $seconds s of building: $output/matern_seeds.png"
  echo
  if [ -n "${DISPLAY:-}" ] && command -v xdg-open >/dev/null; then
    xdg-open "$output/matern_seeds.png" >/dev/null 2>&1 || true
  fi
fi

build ON
example gallery.py "${meshes[@]}"
for pipeline in brain femur; do # from a scan to tetrahedra; an ensemble of shapes
  example medical.py "$pipeline"
done
example flow_matching.py
example geometric_textures.py
# Last, new textures on the surface that was given.
example latent_textures.py ${meshes[0]+--mesh "${meshes[0]}"}

echo
echo "The pictures and surfaces are in $output:"
(cd "$output" && find . -type f \( -name '*.png' -o -name '*.vt[pu]' \) | sort | sed 's|^\./|  |')
