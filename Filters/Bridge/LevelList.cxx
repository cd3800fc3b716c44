// SPDX-License-Identifier: BSD-3-Clause
#include "LevelList.h"

#include "Core/Common/Errors.h"

#include <algorithm>
#include <charconv>
#include <sstream>

namespace surfsynth
{

std::vector<int> ReadLevelList(const std::string& text, const std::string& property)
{
  std::string blanks = text;
  std::replace(blanks.begin(), blanks.end(), ',', ' ');
  std::istringstream words(blanks);
  std::vector<int> levels;
  for (std::string word; words >> word;)
  {
    int level = -1;
    const auto read = std::from_chars(word.data(), word.data() + word.size(), level);
    if (read.ec != std::errc() || read.ptr != word.data() + word.size() || level < 0)
    {
      throw InvalidInput(
        property + " has \"" + word + "\" in it; numbers of levels from 0 on are needed, as in \"0 2\".");
    }
    levels.push_back(level);
  }
  return levels;
}

} // namespace surfsynth
