// SPDX-License-Identifier: BSD-3-Clause
#include "FunctionFilter.h"

#include <vtkInformation.h>

namespace surfsynthtest
{

vtkStandardNewMacro(FunctionFilter);

int FunctionFilter::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObject");
  return this->Input ? this->Input(info) : 1;
}

int FunctionFilter::RequestDataObject(vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  return this->DataObject(this, input, output);
}

int FunctionFilter::RequestData(vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  return this->Data(this, input, output);
}

} // namespace surfsynthtest
