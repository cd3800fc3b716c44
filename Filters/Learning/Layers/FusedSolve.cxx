// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/FusedFields.h"
#include "Learning/Layers/FusedPoisson.h"
#include "Learning/Layers/FusedSteps.h"
#include "Learning/Layers/KeptValue.h"

#include "Core/Common/Errors.h"

#include <algorithm>
#include <cmath>

namespace surfsynth
{

namespace
{
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

/// Solver's rows for some channels of one signal.
class SolvedChannels
{
public:
  SolvedChannels(const PoissonTables& tables, std::int64_t count)
    : Tables(tables)
    , Rows(tables.NumberOfVertices(),
        (count + CholeskySolver::ColumnGranularity - 1) / CholeskySolver::ColumnGranularity *
          CholeskySolver::ColumnGranularity)
    , Count(count)
  {
    this->Rows.rightCols(this->Rows.cols() - count).setZero();
  }

  /// Reads channels @p first and on of a signal [V, channels]; 0 at unused vertices.
  void Read(const float* values, std::int64_t channels, std::int64_t first)
  {
    const std::vector<Index>& order = this->Tables.Solver->Order();
    double check = 0.0;
    for (Eigen::Index row = 0; row < this->Rows.rows(); ++row)
    {
      const float* from = values + order[static_cast<std::size_t>(row)] * channels + first;
      auto to = this->Rows.row(row).head(this->Count);
      to = Eigen::Map<const Eigen::RowVectorXf>(from, this->Count).cast<double>();
      check += to.sum();
    }
    if (!std::isfinite(check))
    {
      throw InvalidInput("PoissonSolve: a right-hand side is not finite; expected finite numbers.");
    }
    for (Eigen::Index row = 0; !this->Tables.Unused.empty() && row < this->Rows.rows(); ++row)
    {
      if (std::binary_search(
            this->Tables.Unused.begin(), this->Tables.Unused.end(), order[static_cast<std::size_t>(row)]))
      {
        this->Rows.row(row).setZero();
      }
    }
  }

  /// Sums over the vertices, weighted by @p mass, which is 1 where it is null.
  Eigen::RowVectorXd Sums(const Eigen::VectorXd* mass) const
  {
    Eigen::RowVectorXd sums = Eigen::RowVectorXd::Zero(this->Rows.cols());
    for (Eigen::Index row = 0; row < this->Rows.rows(); ++row)
    {
      const double weight = mass ? (*mass)[this->Tables.Solver->Order()[static_cast<std::size_t>(row)]] : 1.0;
      sums += weight * this->Rows.row(row);
    }
    return sums;
  }

  /// Subtracts weight * shift, the weights being those of the vertices' mass or 1.
  void Subtract(const Eigen::RowVectorXd& shift, const Eigen::VectorXd* mass)
  {
    for (Eigen::Index row = 0; row < this->Rows.rows(); ++row)
    {
      const double weight = mass ? (*mass)[this->Tables.Solver->Order()[static_cast<std::size_t>(row)]] : 1.0;
      this->Rows.row(row) -= weight * shift;
    }
  }

  void Solve() { this->Tables.Solver->SolveOrderedInPlace(this->Rows); }

  /// Writes the channels; 0 at unused vertices.
  void Write(float* values, std::int64_t channels, std::int64_t first) const
  {
    const std::vector<Index>& order = this->Tables.Solver->Order();
    for (Eigen::Index row = 0; row < this->Rows.rows(); ++row)
    {
      float* to = values + order[static_cast<std::size_t>(row)] * channels + first;
      Eigen::Map<Eigen::RowVectorXf>(to, this->Count) = this->Rows.row(row).head(this->Count).cast<float>();
    }
    for (const Index vertex : this->Tables.Unused)
    {
      std::fill_n(values + vertex * channels + first, this->Count, 0.0F);
    }
  }

private:
  const PoissonTables& Tables;
  RowMatrix Rows;
  std::int64_t Count;
};

/// Calls body(channels, values in, values out, channels of a signal, first) for blocks of channels of each signal.
template <typename Body>
torch::Tensor ForSolvedChannels(const PoissonTables& tables, const torch::Tensor& in, const Body& body)
{
  const torch::Tensor out = torch::empty_like(in);
  const std::int64_t channels = in.size(-1);
  const std::int64_t blocks = (channels + CholeskySolver::BlockColumns - 1) / CholeskySolver::BlockColumns;
  ForStepTasks(BatchOf(in) * blocks, [&](std::int64_t, std::int64_t task) {
    const std::int64_t b = task / blocks;
    const std::int64_t first = channels * (task % blocks) / blocks;
    const std::int64_t count = channels * (task % blocks + 1) / blocks - first;
    SolvedChannels solved(tables, count);
    solved.Read(SignalOf(in, b), channels, first);
    body(solved);
    solved.Write(WritableSignal(out, b), channels, first);
  });
  return out;
}

/// Solution without its mean.
class PoissonSolveStep : public torch::autograd::Function<PoissonSolveStep>
{
public:
  static torch::Tensor forward(
    AutogradContext* context, const std::shared_ptr<const PoissonTables>& tables, const torch::Tensor& rightHandSide)
  {
    KeepValue(context, tables);
    const double total = tables->Mass.sum();
    return ForSolvedChannels(*tables, rightHandSide.contiguous(), [&](SolvedChannels& channels) {
      channels.Solve();
      channels.Subtract(channels.Sums(&tables->Mass) / total, nullptr);
    });
  }

  /// The transposes in reverse order: the matrix is symmetric.
  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstFieldDerivatives();
    const auto tables = KeptValue<std::shared_ptr<const PoissonTables>>(context);
    const double total = tables->Mass.sum();
    return { torch::Tensor(), ForSolvedChannels(*tables, gradients[0].contiguous(), [&](SolvedChannels& channels) {
              channels.Subtract(channels.Sums(nullptr) / total, &tables->Mass);
              channels.Solve();
            }) };
  }
};
} // namespace

torch::Tensor FusedPoissonSolve(const std::shared_ptr<const PoissonTables>& tables, const torch::Tensor& rightHandSide)
{
  return PoissonSolveStep::apply(tables, rightHandSide);
}

} // namespace surfsynth
