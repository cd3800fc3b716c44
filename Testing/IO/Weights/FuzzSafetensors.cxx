// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// libFuzzer target: any bytes are refused with a FormatError, or make a file whose tensors can all be read and which,
/// written and read again, is the same.
#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <cstdlib>
#include <string>

namespace
{
using namespace surfsynth;

/// Uses every byte of the tensor, so that a sanitizer sees one that is not there.
void ReadAll(const SafetensorsFile& file, const std::string& name)
{
  if (!IsFloatingPoint(file.Entry(name).Type))
  {
    file.Integers(name);
    return;
  }
  const std::vector<double> values = file.Float64(name);
  try
  {
    if (file.Float32(name).size() != values.size())
    {
      std::abort();
    }
    file.RequireFinite(name);
  }
  catch (const FormatError&) // too large for float32, or not finite
  {}
}

std::vector<unsigned char> Rewritten(const SafetensorsFile& file)
{
  std::map<std::string, TensorData> tensors;
  for (const auto& [name, entry] : file.Tensors())
  {
    ReadAll(file, name);
    tensors[name] = { entry.Type, entry.Shape, file.Bytes(name) };
  }
  return SerializeSafetensors(tensors, file.Metadata());
}

void ReadWriteRead(const std::string& bytes)
{
  try
  {
    const SafetensorsFile file(bytes.data(), bytes.size(), "fuzz");
    const std::vector<unsigned char> once = Rewritten(file);
    const SafetensorsFile again(once.data(), once.size(), "again");
    if (again.Metadata() != file.Metadata() || again.Tensors().size() != file.Tensors().size() ||
      Rewritten(again) != once)
    {
      std::abort();
    }
  }
  catch (const FormatError&)
  {}
}
} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  ReadWriteRead(bytes);
  // The same bytes behind the length of a header that ends with their last brace: reaches the rules behind the first.
  const std::uint64_t length = bytes.rfind('}') == std::string::npos ? size : bytes.rfind('}') + 1;
  std::string prefixed;
  for (int k = 0; k < 8; ++k)
  {
    prefixed += static_cast<char>(length >> (8 * k) & 0xFFU);
  }
  ReadWriteRead(prefixed + bytes);
  return 0;
}
