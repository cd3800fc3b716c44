// SPDX-License-Identifier: BSD-3-Clause
//
// Stands in for surfacesynthesis-tetgen and misbehaves as the environment variable FAKE_TETGEN says.
#include "MeshProcessing/Tetrahedra/TetGenProtocol.h"

#include <signal.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

using namespace surfsynth::tetgen;

namespace
{
RequestHeader Header;

void ReadEverything()
{
  std::vector<char> bytes(1 << 16);
  bool first = true;
  std::size_t filled = 0;
  for (ssize_t got = 1; got > 0;)
  {
    got = read(STDIN_FILENO, bytes.data() + filled, bytes.size() - filled);
    filled += got > 0 && first ? static_cast<std::size_t>(got) : 0;
    if (first && filled >= sizeof(Header))
    {
      std::memcpy(&Header, bytes.data(), sizeof(Header));
      first = false;
      filled = 0;
    }
  }
}

void Write(const std::vector<char>& bytes)
{
  for (std::size_t done = 0; done < bytes.size();)
  {
    const ssize_t written = write(STDOUT_FILENO, bytes.data() + done, bytes.size() - done);
    if (written <= 0)
    {
      _exit(9);
    }
    done += static_cast<std::size_t>(written);
  }
}

template <typename Value>
void Append(std::vector<char>& bytes, const std::vector<Value>& values)
{
  const char* begin = reinterpret_cast<const char*>(values.data());
  bytes.insert(bytes.end(), begin, begin + values.size() * sizeof(Value));
}

/// One tetrahedron on the first four points, with one new point.
std::vector<char> Reply(std::int64_t points = 1, std::int64_t tetrahedra = 1, std::int32_t corner = 3,
  double coordinate = 0.1, std::int32_t status = Done, std::int32_t code = 0)
{
  ReplyHeader header{};
  std::memcpy(header.Magic, ReplyMagic, sizeof(header.Magic));
  header.Status = status;
  header.Code = code;
  header.Points = points;
  header.Tetrahedra = tetrahedra;
  header.Faces = 1;
  std::vector<char> bytes(sizeof(header));
  std::memcpy(bytes.data(), &header, sizeof(header));
  if (status == Done)
  {
    Append(bytes, std::vector<double>{ coordinate, 0.1, 0.1 });
    Append(bytes, std::vector<std::int32_t>{ 0, 1, 2, corner, 0 });
    Append(bytes, std::vector<std::int32_t>{ 0, 1, 2, 0 });
  }
  return bytes;
}

/// A valid reply with some bytes changed, cut or added.
std::vector<char> Garbled(unsigned int seed)
{
  std::mt19937 random(seed);
  std::vector<char> bytes = Reply();
  for (unsigned int k = random() % 4; k > 0; --k)
  {
    bytes[random() % bytes.size()] = static_cast<char>(random());
  }
  bytes.resize(random() % 3 == 0 ? random() % (bytes.size() + 1) : bytes.size());
  bytes.resize(random() % 5 == 0 ? bytes.size() + random() % 9 : bytes.size(), 'x');
  return bytes;
}

/// A reply that promises two thousand million points, and zeros without end.
void Flood()
{
  std::vector<char> bytes = Reply(std::numeric_limits<std::int32_t>::max());
  for (int k = 0; k < 1000; ++k)
  {
    Write(bytes);
    bytes.assign(1 << 16, 0);
  }
}

/// A valid reply with @p more bytes, or fewer.
void WriteWith(int more)
{
  std::vector<char> bytes = Reply();
  bytes.resize(bytes.size() + static_cast<std::size_t>(more), 'x');
  Write(bytes);
}

/// Ends by a signal that nobody handles: a sanitizer would make an exit status of it.
void Die(int number)
{
  signal(number, SIG_DFL);
  raise(number);
}

void CloseAndHang()
{
  close(STDIN_FILENO);
  close(STDOUT_FILENO);
  pause();
}

void HangAfterReply()
{
  Write(Reply());
  pause();
}

const std::map<std::string, std::function<void()>> Misbehavior = {
  { "crash", [] { Die(SIGSEGV); } },
  { "abort", [] { Die(SIGABRT); } },
  { "killed", [] { raise(SIGKILL); } },
  { "exit", [] { _exit(7); } },
  { "hang", [] { pause(); } },
  { "hang-after-reply", HangAfterReply },
  { "close-and-hang", CloseAndHang },
  { "chatter", [] { Write(std::vector<char>(5000, '?')); } },
  { "flood", Flood },
  { "half", [] { WriteWith(-7); } },
  { "longer", [] { WriteWith(1); } },
  { "negative", [] { Write(Reply(-1)); } },
  { "huge", [] { Write(Reply(std::int64_t(1) << 60)); } },
  { "id", [] { Write(Reply(1, 1, 1000000)); } },
  { "negative-id", [] { Write(Reply(1, 1, -1)); } },
  { "nan", [] { Write(Reply(1, 1, 3, std::numeric_limits<double>::quiet_NaN())); } },
  { "unknown-status", [] { Write(Reply(0, 0, 3, 0.1, 99)); } },
  { "memory", [] { Write(Reply(0, 0, 3, 0.1, OutOfMemory)); } },
};

/// "code3" and "garbled17" have numbers; any other name is silence.
void Misbehave(const std::string& mode)
{
  const auto found = Misbehavior.find(mode);
  if (found != Misbehavior.end())
  {
    found->second();
  }
  else if (mode.rfind("code", 0) == 0)
  {
    Write(Reply(0, 0, 3, 0.1, Terminated, std::atoi(mode.c_str() + 4)));
  }
  else if (mode.rfind("garbled", 0) == 0)
  {
    Write(Garbled(static_cast<unsigned int>(std::atoi(mode.c_str() + 7))));
  }
}
} // namespace

int main()
{
  const char* mode = std::getenv("FAKE_TETGEN");
  if (!mode)
  {
    return 2;
  }
  if (std::strcmp(mode, "deaf") == 0) // never reads
  {
    close(STDIN_FILENO);
    _exit(3);
  }
  ReadEverything();
  Misbehave(mode);
  _exit(0);
}
