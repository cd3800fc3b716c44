// SPDX-License-Identifier: BSD-3-Clause
#include "Announcement.h"

#include "Reporting.h"

#include "Core/Common/FormatNumber.h"
#include "Learning/Training/TrainingClock.h"

#include <vtkAlgorithm.h>
#include <vtkCommand.h>
#include <vtkOutputWindow.h>

namespace surfsynth
{

void AnnounceTime(vtkAlgorithm* self, const std::string& stage, TrainingClock& clock, double budget)
{
  const std::string forecast = clock.TakeForecast();
  if (forecast.empty())
  {
    return;
  }
  std::string text = stage + forecast;
  if (budget > 0.0 && clock.SecondsLeft() > 60.0 * budget)
  {
    text += " The TimeBudget ends this update after " + FormatNumber(budget) + " minutes.";
  }
#ifdef SURFACE_SYNTHESIS_PARAVIEW
  text = InWordsOfParaView(text);
#endif
  if (self->HasObserver(vtkCommand::MessageEvent))
  {
    self->InvokeEvent(vtkCommand::MessageEvent, text.data());
  }
  else
  {
    vtkOutputWindowDisplayText((text + "\n").c_str());
  }
}

} // namespace surfsynth
