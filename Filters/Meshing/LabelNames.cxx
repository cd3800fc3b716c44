// SPDX-License-Identifier: BSD-3-Clause
#include "LabelNames.h"

#include "Core/Common/Errors.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <sstream>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr std::size_t LargestFile = std::size_t(1) << 24;
constexpr const char* Blanks = " \t\r,;";
/// Of UTF-8, which editors put in front of texts.
const std::string ByteOrderMark = "\xef\xbb\xbf";

/// Words of a line: between blanks, or at once where there are tabs; quoted ones without their quotes.
struct Row
{
  std::int32_t Label = 0;
  std::vector<std::string> Words;
  std::string Quoted; ///< the first word in quotes
};

/// True for what has digits, points and signs only.
bool IsNumber(const std::string& word)
{
  return !word.empty() && word.find_first_not_of("0123456789.+-") == std::string::npos &&
    word.find_first_of("0123456789") != std::string::npos;
}

std::vector<std::string> WordsOf(const std::string& text)
{
  std::vector<std::string> words;
  const char* separators = text.find('\t') != std::string::npos ? "\t\r" : Blanks;
  for (std::size_t begin = text.find_first_not_of(separators); begin != std::string::npos;)
  {
    const std::size_t end = text.find_first_of(separators, begin);
    words.push_back(text.substr(begin, end - begin));
    begin = end == std::string::npos ? end : text.find_first_not_of(separators, end);
  }
  return words;
}

/// Splits a line; false when it does not begin with a number.
bool ReadRow(const std::string& line, Row& row)
{
  const std::size_t begin = line.find_first_not_of(Blanks);
  const std::size_t end = line.find_first_of(Blanks, begin);
  const std::string number = line.substr(begin, end == std::string::npos ? end : end - begin);
  const bool digits = number.find_first_not_of("0123456789", number[0] == '-' ? 1 : 0) == std::string::npos;
  if (!digits || number == "-" || number.size() > 11)
  {
    return false;
  }
  const long long label = std::stoll(number);
  if (label < std::numeric_limits<std::int32_t>::min() || label > std::numeric_limits<std::int32_t>::max())
  {
    return false;
  }
  row.Label = static_cast<std::int32_t>(label);
  const std::string rest = end == std::string::npos ? "" : line.substr(end);
  const std::size_t quote = rest.find('"');
  const std::size_t closing = quote == std::string::npos ? quote : rest.find('"', quote + 1);
  row.Quoted = closing == std::string::npos ? "" : rest.substr(quote + 1, closing - quote - 1);
  row.Words = WordsOf(rest);
  return true;
}

std::string Joined(const Row& row, std::size_t leftOut)
{
  std::string name;
  for (std::size_t k = 0; k + leftOut < row.Words.size(); ++k)
  {
    name += (k > 0 ? " " : "") + row.Words[k];
  }
  return name;
}

/// Number of columns of numbers behind all names, without which the names stay different.
std::size_t NumberColumns(const std::vector<Row>& rows)
{
  std::size_t columns = std::numeric_limits<std::size_t>::max();
  for (const Row& row : rows)
  {
    std::size_t numbers = 0;
    while (numbers < row.Words.size() && IsNumber(row.Words[row.Words.size() - 1 - numbers]))
    {
      ++numbers;
    }
    columns = std::min(columns, std::min(numbers, row.Words.size() - 1));
  }
  const auto areDifferent = [&rows](std::size_t leftOut) {
    std::set<std::string> names;
    return std::all_of(
      rows.begin(), rows.end(), [&](const Row& row) { return names.insert(Joined(row, leftOut)).second; });
  };
  return !rows.empty() && areDifferent(columns) ? columns : 0;
}
} // namespace

LabelNameMap ParseLabelNames(const std::string& text, const std::string& path)
{
  std::vector<Row> rows;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number)
  {
    if (number == 1 && line.compare(0, ByteOrderMark.size(), ByteOrderMark) == 0)
    {
      line.erase(0, ByteOrderMark.size());
    }
    const std::size_t begin = line.find_first_not_of(Blanks);
    if (begin == std::string::npos || line[begin] == '#')
    {
      continue;
    }
    Row row;
    const bool read = ReadRow(line, row);
    if (read && !row.Words.empty())
    {
      rows.push_back(row);
    }
    else if (read || !rows.empty() || number > 1)
    {
      throw FormatError(path + ": line " + std::to_string(number) + " is \"" + line.substr(begin, 60) +
        "\"; expected the number of a label and its name.");
    }
  }
  const std::size_t leftOut = NumberColumns(rows);
  LabelNameMap names;
  for (const Row& row : rows)
  {
    const std::string name = row.Quoted.empty() ? Joined(row, leftOut) : row.Quoted;
    const auto [place, isNew] = names.emplace(row.Label, name);
    if (!isNew && place->second != name)
    {
      throw FormatError(path + ": label " + std::to_string(row.Label) + " has the names \"" + place->second +
        "\" and \"" + name + "\"; expected one name for each label.");
    }
  }
  return names;
}

LabelNameMap ReadLabelNames(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  std::string text;
  if (file)
  {
    text.resize(LargestFile + 1);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  }
  if ((!file && !file.eof()) || text.size() > LargestFile || text.find('\0') != std::string::npos)
  {
    throw FormatError(path +
      ": the table of names cannot be read, or is no text of at most 16 MiB; expected a text file "
      "with the number and name of a label in each line.");
  }
  return ParseLabelNames(text, path);
}

} // namespace surfsynth
