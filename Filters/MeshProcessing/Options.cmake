# SPDX-License-Identifier: BSD-3-Clause
#
# The libraries behind the meshing filters, each an option of its own: a filter whose library is off is absent. A file of
# its own, because the ParaView plugin must know them before it lists its XML files.
include_guard(GLOBAL)

option(SURFACE_SYNTHESIS_CGAL
  "Build vtkIsotropicRemeshFilter, vtkPoseEnsembleFilter, vtkSurfaceRepairFilter and vtkTextureAtlasFilter with CGAL (its polygon mesh processing, deformation, approximation and parameterization are GPL-3+)" ON)
option(SURFACE_SYNTHESIS_OPENVDB "Build vtkVDBSurfaceFilter with OpenVDB (MPL-2.0)" ON)
option(SURFACE_SYNTHESIS_TETGEN
  "Build vtkTetrahedralizeFilter, and the program it starts, with TetGen (AGPL-3; linked by that program only)" ON)
