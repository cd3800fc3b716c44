// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Tetrahedra/TetGenClient.h"

#include "MeshProcessing/Tetrahedra/ChildProcess.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <dlfcn.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <new>

namespace surfsynth
{

namespace
{
using tetgen::ReplyHeader;
using tetgen::RequestHeader;

const char* const ProgramName = "surfacesynthesis-tetgen";
const char* const Variable = "SURFACE_SYNTHESIS_TETGEN";
const char* const Repair =
  "vtkSurfaceRepairFilter mends surfaces, and vtkVDBSurfaceFilter makes a closed manifold of any.";

bool IsProgram(const std::string& path) { return access(path.c_str(), X_OK) == 0; }

/// The folder of the library that holds this code, with and without the symbolic links on the way to it.
std::vector<std::string> LibraryFolders()
{
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&FindTetGenProgram), &info) == 0 || !info.dli_fname)
  {
    return {};
  }
  std::vector<std::string> folders;
  const std::unique_ptr<char, void (*)(void*)> real(realpath(info.dli_fname, nullptr), std::free);
  for (const char* file : { info.dli_fname, static_cast<const char*>(real.get()) })
  {
    const std::string path = file ? file : "";
    const std::size_t slash = path.rfind('/');
    folders.push_back(slash == std::string::npos ? "." : path.substr(0, slash));
  }
  return folders;
}

[[noreturn]] void FailToUnderstand(const std::string& found)
{
  throw SolverFailure("The program " + FindTetGenProgram() + " answered " + found +
    "; install the one that belongs to this library beside it, or correct the environment variable " + Variable + ".");
}

/// Cuts the reply into arrays.
class ReplyReader
{
public:
  explicit ReplyReader(const std::vector<char>& bytes)
    : Bytes(bytes)
  {
    std::memcpy(&this->Header, bytes.data(), sizeof(this->Header));
    this->Offset = sizeof(this->Header);
  }

  template <typename Value>
  void Read(Value* values, std::int64_t count)
  {
    const std::size_t size = static_cast<std::size_t>(count) * sizeof(Value);
    if (size > 0)
    {
      std::memcpy(values, this->Bytes.data() + this->Offset, size);
    }
    this->Offset += size;
  }

  ReplyHeader Header;

private:
  const std::vector<char>& Bytes;
  std::size_t Offset;
};

/// The size of a reply with this header.
std::int64_t ReplySize(const ReplyHeader& header, bool wantNeighbors)
{
  if (std::memcmp(header.Magic, tetgen::ReplyMagic, sizeof(header.Magic)) != 0)
  {
    FailToUnderstand("with something that is no reply");
  }
  if (header.Status != tetgen::Done)
  {
    return sizeof(header);
  }
  for (const std::int64_t count : { header.Points, header.Tetrahedra, header.Faces })
  {
    if (count < 0 || count > std::numeric_limits<Index>::max())
    {
      FailToUnderstand("with an impossible number of points, tetrahedra or faces");
    }
  }
  constexpr std::int64_t id = sizeof(std::int32_t);
  return static_cast<std::int64_t>(sizeof(header)) + 24 * header.Points +
    (wantNeighbors ? 9 : 5) * id * header.Tetrahedra + 4 * id * header.Faces;
}

/// @throws SolverFailure when an id or a coordinate of @p mesh is none
void CheckMesh(const TetGenMesh& mesh, const TriangleMesh& surface, std::int64_t seeds)
{
  const std::int64_t points = surface.NumberOfPoints() + mesh.NewPoints.rows();
  const auto within = [](const auto& ids, std::int64_t lowest, std::int64_t end) {
    return std::all_of(ids.data(), ids.data() + ids.size(), [&](Index id) { return id >= lowest && id < end; });
  };
  if (!within(mesh.Tetrahedra, 0, points) || !within(mesh.Faces, 0, points) ||
    !within(mesh.Triangles, 0, surface.NumberOfTriangles()) || !within(mesh.Neighbors, -1, mesh.Tetrahedra.rows()) ||
    !within(mesh.Regions, seeds > 0 ? std::numeric_limits<Index>::min() : -1, std::numeric_limits<Index>::max()))
  {
    FailToUnderstand("with ids of points, tetrahedra or triangles that do not exist");
  }
  if (!mesh.NewPoints.allFinite())
  {
    FailToUnderstand("with points whose coordinates are not finite");
  }
}

TetGenMesh ReadMesh(const std::vector<char>& bytes, const TriangleMesh& surface, const TetGenCall& call)
{
  ReplyReader reader(bytes);
  const std::int64_t tetrahedra = reader.Header.Tetrahedra;
  TetGenMesh mesh;
  mesh.NewPoints.resize(reader.Header.Points, 3);
  mesh.Tetrahedra.resize(tetrahedra, 4);
  mesh.Regions.resize(static_cast<std::size_t>(tetrahedra));
  mesh.Neighbors.resize(call.WantNeighbors ? tetrahedra : 0, 4);
  mesh.Faces.resize(reader.Header.Faces, 3);
  mesh.Triangles.resize(static_cast<std::size_t>(reader.Header.Faces));
  reader.Read(mesh.NewPoints.data(), mesh.NewPoints.size());
  reader.Read(mesh.Tetrahedra.data(), mesh.Tetrahedra.size());
  reader.Read(mesh.Regions.data(), tetrahedra);
  reader.Read(mesh.Neighbors.data(), mesh.Neighbors.size());
  reader.Read(mesh.Faces.data(), mesh.Faces.size());
  reader.Read(mesh.Triangles.data(), reader.Header.Faces);
  if (call.Seeds.empty())
  {
    std::fill(mesh.Regions.begin(), mesh.Regions.end(), 0);
  }
  CheckMesh(mesh, surface, static_cast<std::int64_t>(call.Seeds.size()));
  return mesh;
}

RequestHeader MakeHeader(const TriangleMesh& surface, const TetGenCall& call, tetgen::Task task)
{
  RequestHeader header{};
  std::memcpy(header.Magic, tetgen::RequestMagic, sizeof(header.Magic));
  header.Task = task;
  header.PreserveSurface = call.PreserveSurface ? 1 : 0;
  header.WantNeighbors = call.WantNeighbors ? 1 : 0;
  header.Points = surface.NumberOfPoints();
  header.Triangles = surface.NumberOfTriangles();
  header.Seeds = static_cast<std::int64_t>(call.Seeds.size());
  header.QualityRatio = call.QualityRatio;
  header.MinimumDihedralAngle = call.MinimumDihedralAngle;
  header.MaximumVolume = call.MaximumVolume;
  header.MemoryLimit = call.MemoryLimit;
  return header;
}

ChildResult Ask(const TriangleMesh& surface, const TetGenCall& call, tetgen::Task task, const Progress& progress)
{
  const RequestHeader header = MakeHeader(surface, call, task);
  ChildCall child;
  child.Program = FindTetGenProgram();
  child.Request = { { &header, sizeof(header) },
    { surface.Points.data(), static_cast<std::size_t>(surface.Points.size()) * sizeof(double) },
    { surface.Triangles.data(), static_cast<std::size_t>(surface.Triangles.size()) * sizeof(Index) },
    { call.Seeds.data(), call.Seeds.size() * sizeof(tetgen::Seed) } };
  child.Seconds = call.Seconds;
  child.ExpectedSeconds = 0.2 + 1e-4 * surface.NumberOfTriangles();
  child.HeaderSize = sizeof(ReplyHeader);
  child.OutputSize = [&](const char* bytes) {
    ReplyHeader reply;
    std::memcpy(&reply, bytes, sizeof(reply));
    return ReplySize(reply, call.WantNeighbors);
  };
  return RunChild(child, progress);
}

/// Describes intersections: "12 triangles intersect others, first cell 7"; empty when there are none, or the search
/// takes more than half a minute.
std::string DescribeIntersections(const TriangleMesh& surface, TetGenCall call, const Progress& progress)
{
  call.Seeds.clear();
  call.WantNeighbors = false;
  call.Seconds = call.Seconds > 0.0 ? std::min(call.Seconds, 30.0) : 30.0;
  const ChildResult result = Ask(surface, call, tetgen::FindIntersections, progress);
  if (!result.Complete || ReplyReader(result.Output).Header.Status != tetgen::Done)
  {
    return {};
  }
  std::vector<Index> triangles = ReadMesh(result.Output, surface, call).Triangles;
  if (triangles.empty())
  {
    return {};
  }
  std::sort(triangles.begin(), triangles.end());
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  const std::int64_t first = call.CellOfTriangle ? call.CellOfTriangle(triangles[0]) : triangles[0];
  return "The surface intersects or touches itself: " + std::to_string(triangles.size()) +
    " triangles meet others in more than shared corners and edges, first cell " + std::to_string(first) + "; " + Repair;
}

/// Meaning of the code with which TetGen gives up.
std::string Meaning(std::int32_t code)
{
  switch (code)
  {
    case 3:
      return std::string("The surface intersects itself; ") + Repair;
    case 4:
      return "TetGen found a feature of the surface too small to tell its points apart; vtkCleanPolyData (with a "
             "tolerance) merges points that nearly coincide, vtkIsotropicRemeshFilter makes triangles of one size.";
    case 5:
      return "TetGen found two triangles that nearly touch and could not put points between them; switch "
             "PreserveSurface "
             "on, or separate the parts of the surface.";
    case 10:
      return std::string("TetGen did not accept the surface; ") + Repair;
    default:
      return std::string("TetGen gave up with an internal error (code ") + std::to_string(code) + "); " + Repair;
  }
}

std::string DescribeMemory(const TetGenCall& call)
{
  return "TetGen ran out of memory" +
    (call.MemoryLimit > 0 ? " (MemoryLimit: " + std::to_string(call.MemoryLimit >> 20) + " MiB)" : std::string()) +
    "; larger bounds (QualityRatio, MaximumVolume, TargetEdgeLength) or a coarser surface need less, and MemoryLimit "
    "grants more.";
}

/// Describes the cause of a failure, and remedies.
std::string DescribeFailure(const ChildResult& result, const TetGenCall& call)
{
  if (result.TimedOut)
  {
    return "TetGen did not finish within the TimeLimit of " + FormatNumber(call.Seconds) +
      " s and was stopped; it may never: larger bounds (QualityRatio, MaximumVolume, TargetEdgeLength), a smaller "
      "MinimumDihedralAngle or a coarser surface help, and TimeLimit grants more.";
  }
  if (result.Complete)
  {
    const ReplyHeader header = ReplyReader(result.Output).Header;
    switch (header.Status)
    {
      case tetgen::Terminated:
        return Meaning(header.Code);
      case tetgen::OutOfMemory:
        return DescribeMemory(call);
      default:
        FailToUnderstand("that it does not understand the request");
    }
  }
  if (result.Output.size() >= sizeof(ReplyHeader) &&
    static_cast<std::int64_t>(result.Output.size()) >
      ReplySize(ReplyReader(result.Output).Header, call.WantNeighbors)) // and was ended for it
  {
    FailToUnderstand("with more than its header announces");
  }
  if (result.Signal == SIGKILL)
  {
    return "The process of TetGen was killed from outside, which is what a system does that runs out of memory; a "
           "coarser surface, larger bounds or a lower MemoryLimit spare it.";
  }
  if (result.Signal != 0)
  {
    return std::string("TetGen crashed (signal ") + std::to_string(result.Signal) + ", " + strsignal(result.Signal) +
      "); " + Repair;
  }
  return "TetGen ended the process " +
    (result.ExitStatus >= 0 ? "with exit status " + std::to_string(result.ExitStatus) : std::string("early")) +
    " and without a complete mesh; " + Repair;
}

/// True when a self-intersection may be the cause of the failure.
bool MayIntersect(const ChildResult& result)
{
  if (result.TimedOut || result.Signal == SIGKILL)
  {
    return false;
  }
  return !result.Complete || ReplyReader(result.Output).Header.Status == tetgen::Terminated;
}
} // namespace

std::string FindTetGenProgram()
{
  const char* named = std::getenv(Variable);
  if (named && *named)
  {
    if (!IsProgram(named))
    {
      throw InvalidInput(std::string("The environment variable ") + Variable + " names " + named +
        ", which is no program; it must be the path of " + ProgramName + ".");
    }
    return named;
  }
  const std::vector<std::string> folders = LibraryFolders();
  for (const std::string& folder : folders)
  {
    const std::string path = folder + "/" + ProgramName;
    if (IsProgram(path))
    {
      return path;
    }
  }
  throw InvalidInput(std::string("The program ") + ProgramName + ", which runs TetGen, was not found in " +
    (folders.empty() ? "the folder of this library" : folders.back()) +
    "; install it there, or set the environment variable " + Variable + " to its path.");
}

TetGenMesh RunTetGen(const TriangleMesh& surface, const TetGenCall& call, const Progress& progress)
{
  const ChildResult result = Ask(surface, call, tetgen::Mesh, SubProgress(progress, 0.0, 0.95));
  if (result.Complete && ReplyReader(result.Output).Header.Status == tetgen::Done)
  {
    TetGenMesh mesh = ReadMesh(result.Output, surface, call);
    if (mesh.Tetrahedra.rows() == 0)
    {
      throw SolverFailure(
        std::string("TetGen found that the surface encloses nothing, and made no tetrahedra; ") + Repair);
    }
    return mesh;
  }
  const std::string failure = DescribeFailure(result, call);
  const std::string cause = MayIntersect(result)
    ? DescribeIntersections(surface, call, SubProgress(progress, 0.95, 1.0))
    : "";
  throw SolverFailure(cause.empty() ? failure : cause);
}

} // namespace surfsynth
