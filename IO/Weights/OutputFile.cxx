// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Weights/OutputFile.h"

#include "Core/Common/Errors.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

namespace surfsynth
{

namespace
{
namespace fs = std::filesystem;

constexpr const char* TemporarySuffix = ".tmp";

/// A temporary file beside the wanted one; removed unless it is committed.
class TemporaryFile
{
public:
  TemporaryFile(const std::string& path, const std::string& function)
    : Target(path)
    , Function(function)
  {
    for (int attempt = 0; this->Descriptor < 0; ++attempt)
    {
      this->Path = path + "." + std::to_string(getpid()) + "-" + std::to_string(attempt) + TemporarySuffix;
      this->Descriptor = open(this->Path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (this->Descriptor < 0 && errno != EEXIST)
      {
        this->ThrowCannotWrite();
      }
    }
  }
  ~TemporaryFile()
  {
    if (this->Descriptor >= 0)
    {
      close(this->Descriptor);
    }
    if (!this->Committed)
    {
      std::remove(this->Path.c_str());
    }
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  void Write(std::string_view bytes)
  {
    while (!bytes.empty())
    {
      const ssize_t count = write(this->Descriptor, bytes.data(), bytes.size());
      if (count < 0 && errno != EINTR)
      {
        this->ThrowCannotWrite();
      }
      bytes.remove_prefix(count > 0 ? static_cast<std::size_t>(count) : 0);
    }
  }
  void Commit()
  {
    if (fsync(this->Descriptor) != 0 || close(std::exchange(this->Descriptor, -1)) != 0 ||
      std::rename(this->Path.c_str(), this->Target.c_str()) != 0)
    {
      this->ThrowCannotWrite();
    }
    this->Committed = true;
    this->FlushFolder();
  }

private:
  [[noreturn]] void ThrowCannotWrite() const
  {
    throw InvalidInput(this->Function + ": cannot write " + this->Target + ": " + std::strerror(errno) +
      "; expected a folder that can be written to and space in it.");
  }
  /// The new name is on the disk when its folder is. A file system that cannot flush folders has written the file.
  void FlushFolder() const
  {
    const fs::path folder = fs::absolute(this->Target).parent_path();
    const int descriptor = open(folder.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor >= 0)
    {
      fsync(descriptor);
      close(descriptor);
    }
  }

  std::string Target;
  std::string Function;
  std::string Path;
  int Descriptor = -1;
  bool Committed = false;
};

/// The process that writes a temporary file of @p target, named TARGET.PROCESS-NUMBER.tmp; 0 for other names.
pid_t WriterOf(const std::string& name, const std::string& target)
{
  long process = 0;
  int attempt = 0;
  int length = 0;
  const bool begins = name.size() > target.size() && name.compare(0, target.size(), target) == 0;
  const bool fits = begins &&
    std::sscanf(name.c_str() + target.size(), ".%9ld-%9d.tmp%n", &process, &attempt, &length) == 2 && process > 0 &&
    static_cast<std::size_t>(length) == name.size() - target.size();
  return fits ? static_cast<pid_t>(process) : 0;
}

/// True when @p descriptor is open on the file that has the name now.
bool IsFileOfThatName(int descriptor, const std::string& path)
{
  struct stat opened;
  struct stat named;
  return fstat(descriptor, &opened) == 0 && stat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
    opened.st_ino == named.st_ino;
}
} // namespace

void WriteOutputFile(const std::string& path, std::string_view bytes, const std::string& function)
{
  std::error_code unknown;
  if (fs::exists(path, unknown) && !fs::is_regular_file(path, unknown))
  {
    throw InvalidInput(function + ": cannot write " + path +
      ": it is a folder or a device, which a file would replace; expected the name of a file.");
  }
  TemporaryFile file(path, function);
  file.Write(bytes);
  file.Commit();
}

void RemoveUnfinishedOutput(const std::string& path)
{
  const fs::path target = fs::absolute(path);
  std::error_code failed;
  for (fs::directory_iterator entry(target.parent_path(), failed), end; !failed && entry != end;
       entry.increment(failed))
  {
    const pid_t writer = WriterOf(entry->path().filename().string(), target.filename().string());
    if (writer > 0 && kill(writer, 0) != 0 && errno == ESRCH)
    {
      std::error_code ignored;
      fs::remove(entry->path(), ignored);
    }
  }
}

OutputLock::OutputLock(const std::string& path, const std::string& function)
  : Path(path + ".lock")
{
  while (this->Descriptor < 0)
  {
    const int descriptor = open(this->Path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
    if (descriptor < 0)
    {
      return;
    }
    const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) == 0;
    const bool taken = !locked && errno == EWOULDBLOCK;
    if (locked && IsFileOfThatName(descriptor, this->Path)) // and not one that another process has just removed
    {
      this->Descriptor = descriptor;
      return;
    }
    close(descriptor);
    if (taken)
    {
      throw InvalidInput(function + ": " + path + " is being written by another training, which holds the lock " +
        this->Path + "; expected another name, or the end of that training.");
    }
    if (!locked)
    {
      return; // a file system without locks
    }
  }
}

OutputLock::~OutputLock()
{
  if (this->Descriptor >= 0)
  {
    struct stat opened;
    if (fstat(this->Descriptor, &opened) == 0 && opened.st_size == 0) // and not a file of the user with that name
    {
      std::remove(this->Path.c_str());
    }
    close(this->Descriptor);
  }
}

OutputLock::OutputLock(OutputLock&& other) noexcept
  : Path(std::move(other.Path))
  , Descriptor(std::exchange(other.Descriptor, -1))
{}

} // namespace surfsynth
