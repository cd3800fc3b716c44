// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/SharedProgress.h"

#include "Core/Common/Errors.h"

#include <algorithm>

namespace surfsynth
{

void SharedProgress::Advance(std::int64_t work)
{
  const std::int64_t done = this->Done += work;
  if (this->Stopped)
  {
    throw Cancelled("Stopped on request.");
  }
  if (std::this_thread::get_id() != this->Reporter)
  {
    return;
  }
  // Observers may cost more than the work between two calls.
  const bool muchDone = done - this->LastReportedDone >= this->Total / 100;
  if (muchDone || Clock::now() - this->LastReport >= std::chrono::milliseconds(50))
  {
    this->ReportDone(done);
  }
}

void SharedProgress::ReportDone(std::int64_t done)
{
  this->LastReportedDone = done;
  this->LastReport = Clock::now();
  const double total = static_cast<double>(std::max<std::int64_t>(this->Total, 1));
  try
  {
    Report(this->Callback, std::min(static_cast<double>(done) / total, 1.0));
  }
  catch (...)
  {
    this->Stopped = true;
    throw;
  }
}

} // namespace surfsynth
