// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Tetrahedra/ChildProcess.h"

#include "Core/Common/Errors.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

extern char** environ;

namespace surfsynth
{

namespace
{
using Clock = std::chrono::steady_clock;
constexpr int StepMilliseconds = 50;

double SecondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

[[noreturn]] void FailToStart(const std::string& program, int error)
{
  throw SolverFailure("The program " + program + " could not be started: " + std::strerror(error) + ".");
}

/// A file descriptor that is closed at the end.
class Descriptor
{
public:
  Descriptor() = default;
  explicit Descriptor(int number)
    : Number(number)
  {}
  ~Descriptor() { this->Close(); }
  Descriptor(Descriptor&& other) noexcept
    : Number(std::exchange(other.Number, -1))
  {}
  Descriptor& operator=(Descriptor&& other) noexcept
  {
    std::swap(this->Number, other.Number);
    return *this;
  }
  int Get() const { return this->Number; }
  void Close()
  {
    if (this->Number >= 0)
    {
      close(this->Number);
      this->Number = -1;
    }
  }

private:
  int Number = -1;
};

/// Both ends of a connection. A socket and not a pipe, because writing to it can be told to raise no SIGPIPE. Neither
/// number is below 3, even in a process that has closed its standard streams, so that they do not get into their way.
std::pair<Descriptor, Descriptor> Connect(const std::string& program)
{
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
  {
    FailToStart(program, errno);
  }
  Descriptor first(ends[0]);
  Descriptor second(ends[1]);
  for (Descriptor* end : { &first, &second })
  {
    if (end->Get() < 3)
    {
      const int higher = fcntl(end->Get(), F_DUPFD_CLOEXEC, 3);
      if (higher < 0)
      {
        FailToStart(program, errno);
      }
      *end = Descriptor(higher);
    }
  }
  return { std::move(first), std::move(second) };
}

/// Settings of a new process: our end of the connection as standard input and output, and default signals.
class SpawnSettings
{
public:
  explicit SpawnSettings(int connection)
  {
    posix_spawn_file_actions_init(&this->Actions);
    posix_spawn_file_actions_adddup2(&this->Actions, connection, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&this->Actions, connection, STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&this->Actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 34)
    posix_spawn_file_actions_addclosefrom_np(&this->Actions, 3); // what the host has opened without close-on-exec
#endif
    posix_spawnattr_init(&this->Attributes);
    sigset_t signals;
    sigemptyset(&signals);
    posix_spawnattr_setsigmask(&this->Attributes, &signals);
    sigfillset(&signals);
    posix_spawnattr_setsigdefault(&this->Attributes, &signals);
    posix_spawnattr_setflags(&this->Attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~SpawnSettings()
  {
    posix_spawnattr_destroy(&this->Attributes);
    posix_spawn_file_actions_destroy(&this->Actions);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  posix_spawn_file_actions_t Actions;
  posix_spawnattr_t Attributes;
};

/// A running process, which does not survive this object.
class Child
{
public:
  explicit Child(const std::string& program)
  {
    auto ends = Connect(program);
    const SpawnSettings settings(ends.second.Get());
    std::string name = program;
    char* const arguments[] = { name.data(), nullptr };
    const int error = posix_spawn(
      &this->Id, program.c_str(), &settings.Actions, &settings.Attributes, arguments, environ);
    if (error != 0)
    {
      FailToStart(program, error);
    }
    this->Connection = std::move(ends.first);
  }
  ~Child()
  {
    if (this->Id > 0)
    {
      kill(this->Id, SIGKILL);
      ChildResult ignored;
      this->Wait(0, ignored);
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  int Stream() const { return this->Connection.Get(); }
  void Kill() const { kill(this->Id, SIGKILL); }

  /// Waits for the end, or with WNOHANG only looks; fills @p result and returns true when the process has ended.
  bool Wait(int options, ChildResult& result)
  {
    int status = 0;
    pid_t ended = -1;
    do
    {
      ended = waitpid(this->Id, &status, options);
    } while (ended < 0 && errno == EINTR);
    if (ended == 0)
    {
      return false;
    }
    this->Id = -1;
    result.Signal = ended > 0 && WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    // Without a status the host ignores SIGCHLD, or waits for children that are not its own.
    result.ExitStatus = ended > 0 ? (WIFEXITED(status) ? WEXITSTATUS(status) : 0) : -1;
    return true;
  }

private:
  pid_t Id = -1;
  Descriptor Connection;
};

/// One call of RunChild().
class Conversation
{
public:
  Conversation(const ChildCall& call, const Progress& progress)
    : Call(call)
    , OnProgress(progress)
    , Process(call.Program)
  {}

  ChildResult Run()
  {
    while (!this->Ended && !this->Result.TimedOut)
    {
      pollfd state{ this->Process.Stream(), POLLIN, 0 };
      state.events = static_cast<short>(state.events | (this->Sending ? POLLOUT : 0));
      poll(&state, 1, StepMilliseconds);
      if ((state.revents & POLLOUT) != 0)
      {
        this->Send();
      }
      if ((state.revents & (POLLIN | POLLHUP | POLLERR)) != 0)
      {
        this->Receive();
      }
      this->Step();
    }
    // The stream has ended, and the process should have.
    while (!this->Result.TimedOut && !this->Process.Wait(WNOHANG, this->Result))
    {
      poll(nullptr, 0, 1);
      this->Step();
    }
    if (this->Result.TimedOut)
    {
      this->Process.Kill();
      this->Process.Wait(0, this->Result);
    }
    this->Result.Complete = this->Expected >= 0 &&
      static_cast<std::int64_t>(this->Result.Output.size()) == this->Expected && !this->Result.TimedOut;
    return std::move(this->Result);
  }

private:
  /// Sends as many bytes as the stream takes.
  void Send()
  {
    while (this->Part < this->Call.Request.size())
    {
      const Bytes& part = this->Call.Request[this->Part];
      const std::size_t rest = part.Size - this->Offset;
      const ssize_t sent = rest == 0 ? 0
                                     : send(this->Process.Stream(), static_cast<const char*>(part.Data) + this->Offset,
                                         rest, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0)
      {
        this->Sending = errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; // else it reads no more
        return;
      }
      this->Offset += static_cast<std::size_t>(sent);
      if (this->Offset == part.Size)
      {
        ++this->Part;
        this->Offset = 0;
      }
    }
    this->Sending = false;
    shutdown(this->Process.Stream(), SHUT_WR);
  }

  /// Reads the bytes that have come. More than were announced end the run, too.
  void Receive()
  {
    char buffer[1 << 16];
    const ssize_t got = recv(this->Process.Stream(), buffer, sizeof(buffer), MSG_DONTWAIT);
    if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR))
    {
      return;
    }
    if (got <= 0)
    {
      this->Ended = true;
      return;
    }
    std::vector<char>& output = this->Result.Output;
    output.insert(output.end(), buffer, buffer + got);
    if (this->Expected < 0 && output.size() >= this->Call.HeaderSize)
    {
      this->Expected = this->Call.OutputSize(output.data());
    }
    if (this->Expected >= 0 && static_cast<std::int64_t>(output.size()) > this->Expected)
    {
      this->Process.Kill();
      this->Ended = true;
    }
  }

  /// Reports progress and looks at the clock, about every StepMilliseconds.
  void Step()
  {
    const double seconds = SecondsSince(this->Start);
    if (1000.0 * (seconds - this->LastStep) < StepMilliseconds)
    {
      return;
    }
    this->LastStep = seconds;
    Report(this->OnProgress, seconds / (seconds + this->Call.ExpectedSeconds));
    this->Result.TimedOut = this->Call.Seconds > 0.0 && seconds > this->Call.Seconds;
  }

  const ChildCall& Call;
  const Progress& OnProgress;
  Child Process;
  Clock::time_point Start = Clock::now();
  double LastStep = 0.0;
  std::size_t Part = 0;   ///< of the request
  std::size_t Offset = 0; ///< in this part
  bool Sending = true;
  bool Ended = false;
  std::int64_t Expected = -1;
  ChildResult Result;
};
} // namespace

ChildResult RunChild(const ChildCall& call, const Progress& progress) { return Conversation(call, progress).Run(); }

} // namespace surfsynth
