#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
#
# Unpacks ParaView 5.11 and its development files into a folder, and installs their dependencies beyond those of the
# library, which Examples/install-dependencies.sh installs (Debian 12, as root or with sudo). Takes seconds when nothing
# is missing.
#
#   Wrapping/ParaView/fetch-paraview.sh [folder]
#
# folder: default build/paraview-prefix, the folder of the preset paraview.
#
# ParaView is unpacked and not installed because Debian's Python wrapping of ParaView and of VTK exclude each other.
set -euo pipefail

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)
prefix=$(realpath -m -- "${1:-$root/build/paraview-prefix}")
needed=(
  # MPI, an X server without a screen, Qt's development files for the plugin's widgets
  libopenmpi-dev openmpi-bin xauth xvfb qtbase5-dev
  # libraries that ParaView loads and libvtk9-dev does not install
  libqt5help5 libqt5opengl5 libqt5sql5-sqlite libqt5svg5
)
packages=(paraview paraview-dev python3-paraview)

as_root() {
  if [ "$(id -u)" = 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    echo "This needs root or sudo: $*" >&2
    return 1
  fi
}

updated=0
update() {
  if [ $updated = 0 ]; then
    as_root apt-get update -q
    updated=1
  fi
}

complete=$prefix/.complete
missing=()
for package in "${needed[@]}"; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
  if [ "$status" != installed ]; then
    missing+=("$package")
  fi
done
if [ ${#missing[@]} -gt 0 ]; then
  echo "Installing ${missing[*]}"
  update
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"
fi

if [ ! -e "$complete" ]; then
  echo "Unpacking ParaView into $prefix"
  rm -rf "$prefix"
  mkdir -p "$prefix"
  download=$(mktemp -d)
  trap 'rm -rf "$download"' EXIT
  update
  (cd "$download" && apt-get -q -o APT::Sandbox::User=root download "${packages[@]}")
  for package in "$download"/*.deb; do
    dpkg -x "$package" "$prefix"
  done
  unresolved=$(ldd "$prefix/usr/bin/paraview" "$prefix/usr/bin/pvbatch" | sed -n 's/^\s*\(\S*\) => not found$/\1/p' | sort -u)
  if [ -n "$unresolved" ]; then
    echo "ParaView does not find its libraries: $unresolved" >&2
    exit 1
  fi
  touch "$complete"
fi
echo "ParaView is in $prefix"
