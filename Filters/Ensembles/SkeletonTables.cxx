// SPDX-License-Identifier: BSD-3-Clause
#include "SkeletonTables.h"

#include "Core/Common/Errors.h"

#include <vtkAbstractArray.h>
#include <vtkDataArray.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkTable.h>
#include <vtkVariant.h>

#include <cmath>
#include <limits>
#include <map>

namespace surfsynth
{

namespace
{
using Columns = Eigen::MatrixXd;

/// Columns "Head:0", "Head:1", ..., as files have them, in place of one with components; no rows when there is none.
/// @throws InvalidInput when there are some, but not all.
Columns ReadParts(vtkTable* table, const char* kind, const std::string& name, int components)
{
  Columns values(table->GetNumberOfRows(), components);
  int found = 0;
  std::string missing;
  for (int c = 0; c < components; ++c)
  {
    const std::string partName = name + ":" + std::to_string(c);
    vtkAbstractArray* column = table->GetColumnByName(partName.c_str());
    auto* part = vtkDataArray::SafeDownCast(column);
    found += column ? 1 : 0;
    missing = !part && missing.empty() ? partName : missing;
    for (vtkIdType row = 0; part && row < table->GetNumberOfRows(); ++row)
    {
      values(row, c) = part->GetComponent(row, 0);
    }
  }
  if (found > 0 && !missing.empty())
  {
    throw InvalidInput("The column \"" + missing + "\" of the " + kind +
      " is missing or not numeric, though others of \"" + name + "\" are there; " + std::to_string(components) +
      " are needed, or none.");
  }
  return found > 0 ? values : Columns(0, components);
}

/// A column with components, or those that files have for it; no rows when there is none.
/// @param kind of the table, for messages
/// @throws InvalidInput for one that is not numeric or has another number of components.
Columns ReadColumns(vtkTable* table, const char* kind, const std::string& name, int components)
{
  vtkAbstractArray* column = table->GetColumnByName(name.c_str());
  if (!column)
  {
    return ReadParts(table, kind, name, components);
  }
  auto* whole = vtkDataArray::SafeDownCast(column);
  if (!whole || whole->GetNumberOfComponents() != components)
  {
    throw InvalidInput(std::string("The column \"") + name + "\" of the " + kind +
      (whole ? " has " + std::to_string(whole->GetNumberOfComponents()) + " component(s); " : " is not numeric; ") +
      std::to_string(components) + " are needed.");
  }
  Columns values(table->GetNumberOfRows(), components);
  for (vtkIdType row = 0; row < values.rows(); ++row)
  {
    for (int c = 0; c < components; ++c)
    {
      values(row, c) = whole->GetComponent(row, c);
    }
  }
  return values;
}

void RequireColumn(const Columns& columns, vtkTable* table, const char* kind, const char* name, const char* content)
{
  if (columns.rows() == 0 && table->GetNumberOfRows() > 0)
  {
    throw InvalidInput(
      std::string("The ") + kind + " have no numeric column \"" + name + "\"; " + content + " are needed.");
  }
}

/// Rows of the bones for the rows of the pose.
std::vector<vtkIdType> RowsOfPose(vtkTable* pose, vtkTable* bones)
{
  vtkAbstractArray* names = pose->GetColumnByName("Name");
  vtkAbstractArray* boneNames = bones->GetColumnByName("Name");
  std::vector<vtkIdType> rows;
  if (!names || !boneNames)
  {
    if (pose->GetNumberOfRows() != bones->GetNumberOfRows())
    {
      throw InvalidInput("The pose has " + std::to_string(pose->GetNumberOfRows()) + " row(s) and the skeleton " +
        std::to_string(bones->GetNumberOfRows()) +
        " bone(s); a row for each is needed, or a column \"Name\" in both tables.");
    }
    for (vtkIdType row = 0; row < pose->GetNumberOfRows(); ++row)
    {
      rows.push_back(row);
    }
    return rows;
  }
  std::map<std::string, vtkIdType> boneOf;
  for (vtkIdType row = 0; row < bones->GetNumberOfRows(); ++row)
  {
    const std::string name = boneNames->GetVariantValue(row).ToString();
    if (!boneOf.emplace(name, row).second)
    {
      throw InvalidInput("Two bones have the name \"" + name + "\"; different names are needed.");
    }
  }
  std::vector<bool> isPosed(static_cast<std::size_t>(bones->GetNumberOfRows()), false);
  for (vtkIdType row = 0; row < pose->GetNumberOfRows(); ++row)
  {
    const std::string name = names->GetVariantValue(row).ToString();
    const auto found = boneOf.find(name);
    if (found == boneOf.end() || isPosed[static_cast<std::size_t>(found->second)])
    {
      throw InvalidInput("Row " + std::to_string(row) + " of the pose is for the bone \"" + name + "\", which " +
        (found == boneOf.end() ? "the skeleton does not have" : "another row is for, too") +
        "; one row for each bone is needed.");
    }
    isPosed[static_cast<std::size_t>(found->second)] = true;
    rows.push_back(found->second);
  }
  return rows;
}

vtkDataArray* RequireArray(vtkPointSet* body, const std::string& name, const char* property)
{
  vtkDataArray* array = body->GetPointData()->GetArray(name.c_str());
  if (!array || array->GetNumberOfTuples() != body->GetNumberOfPoints())
  {
    throw InvalidInput("The body has no numeric point array \"" + name + "\" (" + property +
      ") with a tuple for each point; the weights of its bones are needed.");
  }
  return array;
}

/// Bone number of a value; one that is no integer of 32 bits is -2, which no skeleton has.
Index BoneNumber(double value)
{
  const bool isNumber = value == std::floor(value) && std::abs(value) < std::numeric_limits<Index>::max();
  return isNumber ? static_cast<Index>(value) : -2;
}
} // namespace

Skeleton ReadSkeleton(vtkTable* bones)
{
  Skeleton skeleton;
  const Columns heads = ReadColumns(bones, "bones", "Head", 3);
  RequireColumn(heads, bones, "bones", "Head", "3 components, the joint at which each bone turns,");
  const Columns parents = ReadColumns(bones, "bones", "Parent", 1);
  RequireColumn(parents, bones, "bones", "Parent", "the rows of the bones that carry them, -1 for none,");
  skeleton.Heads = heads;
  for (Eigen::Index b = 0; b < parents.rows(); ++b)
  {
    skeleton.Parents.push_back(BoneNumber(parents(b, 0)));
  }
  return skeleton;
}

SkeletonPose ReadSkeletonPose(vtkTable* pose, vtkTable* bones)
{
  const Columns rotations = ReadColumns(pose, "pose", "Rotation", 4);
  RequireColumn(
    rotations, pose, "rows of the pose", "Rotation", "4 components, a quaternion w, x, y, z for each bone,");
  const Columns translations = ReadColumns(pose, "pose", "Translation", 3);
  const std::vector<vtkIdType> rows = RowsOfPose(pose, bones);
  SkeletonPose result;
  result.Rotations.setZero(bones->GetNumberOfRows(), 4);
  result.Rotations.col(0).setOnes();
  result.Translations.setZero(bones->GetNumberOfRows(), 3);
  for (std::size_t k = 0; k < rows.size(); ++k)
  {
    result.Rotations.row(rows[k]) = rotations.row(static_cast<Eigen::Index>(k));
    if (translations.rows() > 0)
    {
      result.Translations.row(rows[k]) = translations.row(static_cast<Eigen::Index>(k));
    }
  }
  return result;
}

SkinWeights ReadSkinWeights(vtkPointSet* body, const std::string& indexName, const std::string& weightName)
{
  vtkDataArray* values = RequireArray(body, weightName, "BoneWeightArrayName");
  vtkDataArray* bones = indexName.empty() ? nullptr : RequireArray(body, indexName, "BoneIndexArrayName");
  const int influences = values->GetNumberOfComponents();
  if (bones && bones->GetNumberOfComponents() != influences)
  {
    throw InvalidInput("The arrays \"" + indexName + "\" and \"" + weightName + "\" have " +
      std::to_string(bones->GetNumberOfComponents()) + " and " + std::to_string(influences) +
      " components; the same number is needed.");
  }
  SkinWeights weights;
  weights.Bones.resize(body->GetNumberOfPoints(), influences);
  weights.Values.resize(body->GetNumberOfPoints(), influences);
  for (vtkIdType v = 0; v < body->GetNumberOfPoints(); ++v)
  {
    for (int k = 0; k < influences; ++k)
    {
      weights.Values(v, k) = values->GetComponent(v, k);
      weights.Bones(v, k) = bones ? BoneNumber(bones->GetComponent(v, k)) : static_cast<Index>(k);
    }
  }
  return weights;
}

} // namespace surfsynth
