// SPDX-License-Identifier: BSD-3-Clause
//
// surfacesynthesis-tetgen: reads one surface from its standard input, has TetGen (AGPL-3, linked by this program only)
// make tetrahedra of it, and writes them to its standard output. TetGen may crash, end the process or never come back:
// whoever starts this program waits for it with a time limit.
#include "MeshProcessing/Tetrahedra/TetGenProtocol.h"

#include "Core/Common/Sanitizers.h"

// The library calls terminatetetgen() for every error. Its own version, which the header would define again, frees the
// mesh and throws, so that the destructor frees it once more; the one below takes its place.
#define TETLIBRARY
#define terminatetetgen terminatetetgenOfTheHeader
#include <tetgen.h>
#undef terminatetetgen

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>
#ifdef __linux__
#include <csignal>
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <new>
#include <vector>

using namespace surfsynth::tetgen;

namespace
{
int Output = -1; ///< where the reply goes

bool WriteAll(const void* data, std::size_t size)
{
  const char* bytes = static_cast<const char*>(data);
  while (size > 0)
  {
    const ssize_t written = write(Output, bytes, std::min<std::size_t>(size, 1 << 20));
    if (written < 0 && errno == EINTR)
    {
      continue;
    }
    if (written <= 0)
    {
      return false;
    }
    bytes += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

bool ReadAll(void* data, std::size_t size)
{
  char* bytes = static_cast<char*>(data);
  while (size > 0)
  {
    const ssize_t got = read(STDIN_FILENO, bytes, std::min<std::size_t>(size, 1 << 20));
    if (got < 0 && errno == EINTR)
    {
      continue;
    }
    if (got <= 0)
    {
      return false;
    }
    bytes += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

/// Ends the process with a reply without tetrahedra. No destructor runs: the state of TetGen may be invalid.
[[noreturn]] void Fail(Status status, int code = 0)
{
  ReplyHeader reply{};
  std::memcpy(reply.Magic, ReplyMagic, sizeof(reply.Magic));
  reply.Status = status;
  reply.Code = code;
  _exit(WriteAll(&reply, sizeof(reply)) ? 0 : 1);
}

[[noreturn]] void FailForMemory() { Fail(OutOfMemory); }

struct Request
{
  RequestHeader Header;
  std::vector<double> Points;
  std::vector<std::int32_t> Triangles;
  std::vector<Seed> Seeds;
};

template <typename Value>
void ReadArray(std::vector<Value>& values, std::int64_t size)
{
  if (size < 0 || size > std::numeric_limits<std::int32_t>::max())
  {
    Fail(BadRequest);
  }
  values.resize(static_cast<std::size_t>(size));
  if (!ReadAll(values.data(), values.size() * sizeof(Value)))
  {
    Fail(BadRequest);
  }
}

void LimitMemory(std::int64_t bytes)
{
  if (bytes > 0 && !surfsynth::HasSanitizer())
  {
    const rlimit limit{ static_cast<rlim_t>(bytes), static_cast<rlim_t>(bytes) };
    setrlimit(RLIMIT_AS, &limit);
  }
}

Request ReadRequest()
{
  Request request;
  RequestHeader& header = request.Header;
  if (!ReadAll(&header, sizeof(header)) || std::memcmp(header.Magic, RequestMagic, sizeof(header.Magic)) != 0)
  {
    Fail(BadRequest);
  }
  LimitMemory(header.MemoryLimit);
  const std::int64_t most = std::numeric_limits<std::int32_t>::max() / 3;
  if (header.Points < 4 || header.Points > most || header.Triangles < 4 || header.Triangles > most)
  {
    Fail(BadRequest);
  }
  ReadArray(request.Points, 3 * header.Points);
  ReadArray(request.Triangles, 3 * header.Triangles);
  ReadArray(request.Seeds, header.Seeds);
  const auto isId = [&](std::int32_t id) { return id >= 0 && id < header.Points; };
  if (!std::all_of(request.Triangles.begin(), request.Triangles.end(), isId))
  {
    Fail(BadRequest);
  }
  return request;
}

/// A facet for each triangle, marked with its number from 1 on.
void SetSurface(const Request& request, tetgenio& input)
{
  input.numberofpoints = static_cast<int>(request.Header.Points);
  input.pointlist = new REAL[request.Points.size()];
  std::copy(request.Points.begin(), request.Points.end(), input.pointlist);
  input.numberoffacets = static_cast<int>(request.Header.Triangles);
  input.facetlist = new tetgenio::facet[static_cast<std::size_t>(input.numberoffacets)];
  input.facetmarkerlist = new int[static_cast<std::size_t>(input.numberoffacets)];
  for (int f = 0; f < input.numberoffacets; ++f)
  {
    const std::int32_t* corners = request.Triangles.data() + 3 * static_cast<std::size_t>(f);
    tetgenio::facet& facet = input.facetlist[f];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    facet.polygonlist[0].numberofvertices = 3;
    facet.polygonlist[0].vertexlist = new int[3]{ corners[0], corners[1], corners[2] };
    input.facetmarkerlist[f] = f + 1;
  }
}

/// Regions are numbered from 1 on in TetGen's attributes.
void SetSeeds(const std::vector<Seed>& seeds, tetgenio& input)
{
  std::vector<double> regions;
  std::vector<double> holes;
  for (const Seed& seed : seeds)
  {
    std::vector<double>& list = seed.Region < 0 ? holes : regions;
    list.insert(list.end(), seed.Place, seed.Place + 3);
    if (seed.Region >= 0)
    {
      list.insert(list.end(), { static_cast<double>(seed.Region) + 1.0, 0.0 });
    }
  }
  const auto newList = [](const std::vector<double>& values) {
    REAL* list = values.empty() ? nullptr : new REAL[values.size()];
    std::copy(values.begin(), values.end(), list);
    return list;
  };
  input.regionlist = newList(regions);
  input.numberofregions = static_cast<int>(regions.size() / 5);
  input.holelist = newList(holes);
  input.numberofholes = static_cast<int>(holes.size() / 3);
}

/// The switches, by letters where these set more than one field, and the numbers, which letters cannot say exactly.
void SetBehavior(const RequestHeader& header, tetgenbehavior& behavior)
{
  char letters[32] = "pJMQ"; // a surface; keep all points, all facets, and quiet
  const bool bounded = header.QualityRatio > 0.0 || header.MinimumDihedralAngle > 0.0 || header.MaximumVolume > 0.0;
  std::strcat(letters, header.Task == FindIntersections ? "d" : "");
  std::strcat(letters, header.PreserveSurface && header.Task == Mesh ? "Y" : "");
  std::strcat(letters, bounded && header.Task == Mesh ? "q" : "");
  std::strcat(letters, header.MaximumVolume > 0.0 && header.Task == Mesh ? "a1" : "");
  std::strcat(letters, header.Seeds > 0 ? "A" : "");
  std::strcat(letters, header.WantNeighbors ? "n" : "");
  if (!behavior.parse_commandline(letters))
  {
    Fail(BadRequest);
  }
  behavior.minratio = header.QualityRatio > 0.0 ? header.QualityRatio : 1e6;
  behavior.mindihedral = header.MinimumDihedralAngle;
  if (header.MaximumVolume > 0.0)
  {
    behavior.maxvolume = header.MaximumVolume;
  }
}

bool WriteReply(const Request& request, const tetgenio& output)
{
  const std::int64_t given = request.Header.Points;
  const bool meshed = request.Header.Task == Mesh;
  ReplyHeader reply{};
  std::memcpy(reply.Magic, ReplyMagic, sizeof(reply.Magic));
  reply.Status = Done;
  reply.Points = meshed ? std::max<std::int64_t>(output.numberofpoints - given, 0) : 0;
  reply.Tetrahedra = meshed ? output.numberoftetrahedra : 0;
  reply.Faces = output.numberoftrifaces;
  const auto tetrahedra = static_cast<std::size_t>(reply.Tetrahedra);
  const auto faces = static_cast<std::size_t>(reply.Faces);
  std::vector<std::int32_t> regions(tetrahedra, 0);
  if (output.numberoftetrahedronattributes > 0)
  {
    for (std::size_t t = 0; t < tetrahedra; ++t)
    {
      const double region = output.tetrahedronattributelist[t * output.numberoftetrahedronattributes];
      regions[t] = static_cast<std::int32_t>(region) - 1;
    }
  }
  std::vector<std::int32_t> triangles(output.trifacemarkerlist, output.trifacemarkerlist + faces);
  std::for_each(triangles.begin(), triangles.end(), [](std::int32_t& marker) { --marker; });
  return WriteAll(&reply, sizeof(reply)) &&
    WriteAll(output.pointlist + 3 * given, 3 * static_cast<std::size_t>(reply.Points) * sizeof(double)) &&
    WriteAll(output.tetrahedronlist, 4 * tetrahedra * sizeof(std::int32_t)) &&
    WriteAll(regions.data(), tetrahedra * sizeof(std::int32_t)) &&
    WriteAll(output.neighborlist, request.Header.WantNeighbors ? 4 * tetrahedra * sizeof(std::int32_t) : 0) &&
    WriteAll(output.trifacelist, 3 * faces * sizeof(std::int32_t)) &&
    WriteAll(triangles.data(), faces * sizeof(std::int32_t));
}

/// Reserves the stream of the reply: the output of TetGen is discarded.
void TakeOutput()
{
  Output = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (Output < 0 || nowhere < 0 || dup2(nowhere, STDOUT_FILENO) < 0)
  {
    _exit(1);
  }
}
} // namespace

/// The end of every error inside TetGen.
void terminatetetgen(tetgenmesh*, int code)
{
  if (code == 1)
  {
    FailForMemory();
  }
  Fail(Terminated, code);
}

int main()
{
  TakeOutput();
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL); // nobody would read the reply
#endif
  const rlimit noCore{ 0, 0 };
  setrlimit(RLIMIT_CORE, &noCore);
  std::set_new_handler(FailForMemory);

  const Request request = ReadRequest();
  tetgenio input;
  tetgenio output;
  tetgenbehavior behavior;
  SetSurface(request, input);
  SetSeeds(request.Seeds, input);
  SetBehavior(request.Header, behavior);
  try
  {
    tetrahedralize(&behavior, &input, &output);
  }
  catch (...) // of the library's own, should it have kept its version of terminatetetgen()
  {
    Fail(Terminated, 2);
  }
  _exit(WriteReply(request, output) ? 0 : 1);
}
