#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
#
# Installs what the project needs on Debian 12 and makes OpenBLAS the BLAS in use. Quick when nothing is missing.
#
#   Examples/install-dependencies.sh [--testing]
#
# --testing adds what only the tests need. Runs as root, or with sudo.
set -euo pipefail

packages=(
  # tools
  ca-certificates ccache cmake g++ git ninja-build
  # VTK (BSD-3-Clause), and Python (PSF-2.0) with its wrapping of VTK
  libvtk9-dev python3 python3-numpy python3-vtk9
  # Eigen (MPL-2.0), CHOLMOD (LGPL-2.1+, supernodal part GPL-2+), OpenBLAS (BSD-3-Clause)
  libeigen3-dev libopenblas-dev libopenblas0-pthread libsuitesparse-dev
  # CGAL (its polygon mesh processing GPL-3+), with Boost (BSL-1.0), GMP and MPFR (LGPL-3+)
  libboost-dev libcgal-dev libgmp-dev libmpfr-dev
  # OpenVDB (MPL-2.0), with TBB (Apache-2.0) and Imath (BSD-3-Clause)
  libimath-dev libopenvdb-dev libtbb-dev
  # LibTorch (BSD-3-Clause)
  libtorch-dev
  # header-only: nanoflann (BSD-2-Clause), nlohmann-json (MIT), Random123 (BSD-3-Clause), Spectra (MPL-2.0)
  libnanoflann-dev librandom123-dev libspectra-dev nlohmann-json3-dev
  # TetGen (AGPL-3, linked by the program surfacesynthesis-tetgen only)
  libtet1.5-dev
  # files of scanners and of neuroimaging, in Python: GDCM (BSD-3-Clause), nibabel (MIT)
  python3-gdcm python3-nibabel
  # the examples: surfaces and scans, images, plots and an X server without a screen
  libcgal-demo mricron-data python3-matplotlib python3-pil xauth xvfb
)
testing_packages=(
  clang clang-format clang-tidy libbenchmark-dev libclang-rt-14-dev libgmock-dev libgtest-dev python3-pytest python3-scipy
  # meshes distributed over ranks: PETSc (BSD-2-Clause) with hypre (Apache-2.0 or MIT), Open MPI (BSD-3-Clause)
  libopenmpi-dev libpetsc-real-dev openmpi-bin pkg-config
  # packages and wheels, before a release
  debootstrap dpkg-dev python3-pip python3-skbuild python3-venv
)
if [ "${1:-}" = --testing ]; then
  packages+=("${testing_packages[@]}")
fi

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

if ! command -v dpkg-query >/dev/null; then
  echo "This is not a Debian system. Install the equivalents of: ${packages[*]}" >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
  if [ "$status" != installed ]; then
    missing+=("$package")
  fi
done

apt_install=(env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends
  # minimal images leave out documentation, among which the surfaces of libcgal-demo lie
  -o "Dpkg::Options::=--path-include=/usr/share/doc/libcgal-dev/*")
if [ ${#missing[@]} -gt 0 ]; then
  echo "Installing ${missing[*]}"
  as_root apt-get update -q
  as_root "${apt_install[@]}" "${missing[@]}"
fi

surfaces=/usr/share/doc/libcgal-dev/data.tar.gz
if [ ! -e $surfaces ]; then
  as_root apt-get update -q
  as_root "${apt_install[@]}" --reinstall libcgal-demo
  if [ ! -e $surfaces ]; then
    echo "libcgal-demo did not bring $surfaces" >&2
    exit 1
  fi
fi

# Programs find BLAS and LAPACK through links, which may still lead to a slower implementation.
architecture=$(g++ -print-multiarch)
for library in libblas liblapack; do
  for suffix in .so.3 .so; do
    name=$library$suffix-$architecture
    link=/usr/lib/$architecture/$library$suffix
    wanted=/usr/lib/$architecture/openblas-pthread/$library$suffix
    if [ -e "$wanted" ] && [[ "$(readlink -f "$link" || true)" != *openblas* ]]; then
      as_root update-alternatives --set "$name" "$wanted"
    fi
  done
  if [[ "$(readlink -f "/usr/lib/$architecture/$library.so.3")" != *openblas* ]]; then
    echo "Warning: /usr/lib/$architecture/$library.so.3 does not lead to OpenBLAS" >&2
  fi
done
