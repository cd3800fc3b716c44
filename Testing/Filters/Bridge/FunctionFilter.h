// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Filter whose requests are functions.
#pragma once

#include <vtkDataObjectAlgorithm.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>

#include <functional>

namespace surfsynthtest
{

/// Filter that calls functions in place of RequestDataObject and RequestData.
class FunctionFilter : public vtkDataObjectAlgorithm
{
public:
  static FunctionFilter* New();
  vtkTypeMacro(FunctionFilter, vtkDataObjectAlgorithm);

  using Request = std::function<int(vtkAlgorithm*, vtkInformationVector**, vtkInformationVector*)>;

  Request DataObject;                        ///< RequestDataObject
  Request Data;                              ///< RequestData
  std::function<int(vtkInformation*)> Input; ///< FillInputPortInformation; without it any data object is accepted

protected:
  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(vtkInformation*, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(vtkInformation*, vtkInformationVector** input, vtkInformationVector* output) override;
};

} // namespace surfsynthtest
