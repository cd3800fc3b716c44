// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Requests of second inputs.
#pragma once

#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkStreamingDemandDrivenPipeline.h>

namespace surfsynth
{

/// Requests all of the inputs of a port, whatever piece of the output is asked for: a texture, or a surface to lay it on,
/// is needed as a whole.
inline void RequestWhole(vtkInformationVector* port)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  for (int k = 0; k < port->GetNumberOfInformationObjects(); ++k)
  {
    vtkInformation* info = port->GetInformationObject(k);
    info->Set(Pipeline::UPDATE_PIECE_NUMBER(), 0);
    info->Set(Pipeline::UPDATE_NUMBER_OF_PIECES(), 1);
    info->Set(Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
    if (info->Has(Pipeline::WHOLE_EXTENT()))
    {
      info->Set(Pipeline::UPDATE_EXTENT(), info->Get(Pipeline::WHOLE_EXTENT()), 6);
    }
  }
}

} // namespace surfsynth
