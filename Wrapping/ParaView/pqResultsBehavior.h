// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqResultsBehavior
 * @brief   Shows results of the plugin's filters as a person wants to see them, where ParaView's defaults do not
 *
 *  - The table of Topology Report leads with Property and Value. ParaView orders columns by name.
 *  - A filter whose first update failed is colored by its array once an update succeeds. ParaView chooses colors once,
 *    when the empty result is shown.
 *  - Colors of points, the output that the hint DirectColors names, are shown as they are. ParaView would map the lengths
 *    of such vectors to colors.
 */

#ifndef pqResultsBehavior_h
#define pqResultsBehavior_h

#include <QObject>
#include <QSet>

class QHeaderView;
class pqOutputPort;
class pqPipelineSource;
class pqRepresentation;
class pqView;

class pqResultsBehavior : public QObject
{
  Q_OBJECT
  typedef QObject Superclass;

public:
  explicit pqResultsBehavior(QObject* parent = nullptr);
  ~pqResultsBehavior() override = default;

  void onStartup();
  void onShutdown();

private:
  Q_DISABLE_COPY(pqResultsBehavior)

  void watchTable(pqView* view);
  void colorLateResults(pqPipelineSource* source);

  static void showDirectColors(pqRepresentation* shown);
  static void leadWithValues(QHeaderView* header);
  static void colorByArray(pqOutputPort* port);

  QSet<pqOutputPort*> EmptyPorts; ///< shown without data; compared, never followed
};

#endif
