// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tables of the names of labels. Private to the module.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace surfsynth
{

using LabelNameMap = std::map<std::int32_t, std::string>;

/// Reads a text with a line for each label: its number, then its name, as in the tables of MRIcron ("1 Precentral_L 2001"),
/// FreeSurfer ("2 Left-Cerebral-White-Matter 245 245 245 0"), ITK-SNAP (name in quotes) and in comma- or tab-separated
/// columns. Empty lines, lines that begin with # and a first line without a number are left out; so are columns of numbers
/// behind all names, where names stay different without them.
/// @throws FormatError naming the file and the first line that has no number and name, or two names of a label
LabelNameMap ParseLabelNames(const std::string& text, const std::string& path);

/// The same of a file. @throws FormatError also when it cannot be read, or is larger than 16 MiB
LabelNameMap ReadLabelNames(const std::string& path);

} // namespace surfsynth
