#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
#
# From nothing to ParaView with the plugin: installs what is missing (Debian 12, as root or with sudo), unpacks ParaView
# into build/paraview-prefix, builds the plugin, and opens ParaView with the demo. Without a display it renders the demo
# into Examples/Output/ParaView instead.
#
#   Examples/ParaView/run.sh [state or data file]
#
# Environment: JOBS (parallel compilations, default the number of processors).
set -euo pipefail

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)
jobs=${JOBS:-$(nproc)}
if [ $# -gt 1 ]; then
  echo "usage: $0 [state or data file]" >&2
  exit 2
fi
file=${1:-$root/Examples/ParaView/MaternNoise.py}
if [ ! -f "$file" ]; then
  echo "$0: no file $file" >&2
  exit 2
fi
file=$(realpath -- "$file")

bash "$root/Examples/install-dependencies.sh"
bash "$root/Wrapping/ParaView/fetch-paraview.sh"

cd "$root"
export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER:-ccache}
build=$root/build/paraview-example
cmake --preset paraview -B "$build" -DSURFACE_SYNTHESIS_TESTING=OFF -DSURFACE_SYNTHESIS_WERROR=OFF
cmake --build "$build" --parallel "$jobs"
plugins=$build/lib/paraview-5.11/plugins/SurfaceSynthesis
paraview=$root/build/paraview-prefix/usr/bin

case "$file" in
  *.py | *.pvsm) kind=--state ;;
  *) kind=--data ;;
esac
if [ -n "${DISPLAY:-}" ]; then
  exec "$paraview/paraview" --plugin-search-paths "$plugins" --plugins SurfaceSynthesis "$kind=$file"
fi
if [ $kind = --data ]; then
  echo "$0: without a display only state files (.py, .pvsm) can be rendered" >&2
  exit 2
fi
output=$root/Examples/Output/ParaView
mkdir -p "$output"
picture=$output/$(basename "${file%.*}").png
xvfb-run -a -s "-screen 0 1280x1024x24 -noreset" \
  "$paraview/pvpython" "$root/Examples/ParaView/screenshot.py" "$plugins/SurfaceSynthesis.so" "$file" "$picture"
echo "There is no display. The picture is $picture"
