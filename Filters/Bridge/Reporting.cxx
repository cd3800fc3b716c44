// SPDX-License-Identifier: BSD-3-Clause
#include "Reporting.h"

#include <vtkAlgorithm.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

namespace surfsynth
{

namespace
{
/// Labels of filters in ParaView's menu, and ParaView's names of types of data. One table, which is looked up as one.
const std::map<std::string, std::string>& LabelsOfClasses()
{
  static const std::map<std::string, std::string> labels = {
    // filters of the plugin
    { "vtkDisplacementMapFilter", "Displacement Map" },
    { "vtkElasticRestFilter", "Elastic Rest" },
    { "vtkEnsembleLayoutFilter", "Ensemble Layout" },
    { "vtkEnsembleMetrics", "Ensemble Metrics" },
    { "vtkEnsembleStatistics", "Ensemble Statistics" },
    { "vtkFieldLatentDecoder", "Field Latent Decoder" },
    { "vtkFieldLatentEncoder", "Field Latent Encoder" },
    { "vtkFieldLatentTextureFilter", "Field Latent Texture" },
    { "vtkFieldLatentTrainer", "Field Latent Trainer" },
    { "vtkFlowMatchingDeformer", "Flow Matching Deformer" },
    { "vtkFlowMatchingSampler", "Flow Matching Sampler" },
    { "vtkFlowMatchingTrainer", "Flow Matching Trainer" },
    { "vtkGaussianMixtureFilter", "Gaussian Mixture" },
    { "vtkGeometricTextureDistance", "Geometric Texture Distance" },
    { "vtkGeometricTextureFeatures", "Geometric Texture Features" },
    { "vtkGeometricTextureFromExample", "Geometric Texture From Example" },
    { "vtkGeometricTextureSynthesizer", "Geometric Texture Synthesizer" },
    { "vtkGeometricTextureTrainer", "Geometric Texture Trainer" },
    { "vtkIsotropicRemeshFilter", "Isotropic Remesh" },
    { "vtkLabelSurfaceFilter", "Label Surfaces" },
    { "vtkLatentDiffusionTrainer", "Latent Diffusion Trainer" },
    { "vtkMaternNoiseFilter", "Matern Noise" },
    { "vtkMaternParameterEstimator", "Matern Parameter Estimator" },
    { "vtkMultiscaleMeshFitter", "Multiscale Mesh Fitter" },
    { "vtkPoissonNetFilter", "PoissonNet" },
    { "vtkPoseEnsembleFilter", "Pose Ensemble" },
    { "vtkShapeModelSampler", "Shape Model Sampler" },
    { "vtkSkinningFilter", "Skinning" },
    { "vtkSurfaceDistance", "Surface Distance" },
    { "vtkSurfaceRepairFilter", "Surface Repair" },
    { "vtkTetrahedralizeFilter", "Tetrahedralize Surface" },
    { "vtkTextureAtlasFilter", "Texture Atlas" },
    { "vtkTopologyReport", "Topology Report" },
    { "vtkVDBSurfaceFilter", "VDB Surface" },
    // ParaView's filters, with the nearest one where it lacks that of VTK
    { "vtkAdaptiveSubdivisionFilter", "Subdivide" },
    { "vtkAggregateDataSetFilter", "Aggregate Dataset" },
    { "vtkArrayCalculator", "Calculator" },
    { "vtkCleanPolyData", "Clean" },
    { "vtkDataSetSurfaceFilter", "Extract Surface" },
    { "vtkDataSetTriangleFilter", "Tetrahedralize" },
    { "vtkDelaunay2D", "Delaunay 2D" },
    { "vtkExtractBlock", "Extract Block" },
    { "vtkExtractVOI", "Extract Subset" },
    { "vtkFeatureEdges", "Feature Edges" },
    { "vtkFillHolesFilter", "VDB Surface" },
    { "vtkImageCast", "Calculator" },
    { "vtkImageReslice", "Resample To Image" },
    { "vtkImageThreshold", "Threshold" },
    { "vtkMergeBlocks", "Merge Blocks" },
    { "vtkPolyDataConnectivityFilter", "Connectivity" },
    { "vtkPolyDataNormals", "Generate Surface Normals" },
    { "vtkResampleToImage", "Resample To Image" },
    { "vtkReverseSense", "Reverse Sense" },
    { "vtkSurfaceReconstructionFilter", "Delaunay 3D with Extract Surface" },
    { "vtkThreshold", "Threshold" },
    { "vtkTransformFilter", "Transform" },
    { "vtkTransformPolyDataFilter", "Transform" },
    { "vtkTriangleFilter", "Triangulate" },
    { "vtkWarpVector", "Warp By Vector" },
    // types of data
    { "vtkDataObjectTree", "Composite Dataset" },
    { "vtkImageData", "Image" },
    { "vtkMultiBlockDataSet", "Multi-block Dataset" },
    { "vtkPointSet", "Point Set" },
    { "vtkPolyData", "Polygonal Mesh" },
    { "vtkRectilinearGrid", "Rectilinear Grid" },
    { "vtkStructuredGrid", "Structured Grid" },
    { "vtkTable", "Table" },
    { "vtkUnstructuredGrid", "Unstructured Grid" },
  };
  return labels;
}

/// Names of libraries and methods, which are no properties.
bool IsProperName(const std::string& word)
{
  static const std::set<std::string> names = { "LibTorch", "ParaView", "PoissonNet", "PyTorch", "TetGen" };
  return names.count(word) > 0;
}

bool IsWordCharacter(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

bool IsUpper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }

bool IsLower(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }

/// Several words written as one: ModelFileName. Abbreviations (MPI), single words and names of variables are none.
bool IsCamelCase(const std::string& word)
{
  const auto lettersOnly = [](char c) { return IsUpper(c) || IsLower(c); };
  return std::count_if(word.begin(), word.end(), IsUpper) >= 2 && IsUpper(word.front()) && IsLower(word.back()) &&
    std::all_of(word.begin(), word.end(), lettersOnly);
}

/// Value of an enumeration: ALL_HOLES.
bool IsEnumerator(const std::string& word)
{
  static const std::set<std::string> single = { "FREE", "GIVEN", "REMESH", "SUBDIVIDE" };
  const auto fits = [](char c) { return IsUpper(c) || c == '_'; };
  return single.count(word) > 0 ||
    (word.find('_') != std::string::npos && IsUpper(word.front()) && word.compare(0, 8, "SURFACE_") != 0 &&
      std::all_of(word.begin(), word.end(), fits));
}

/// "Model File Name" for ModelFileName.
std::string Spaced(const std::string& word)
{
  std::string label;
  for (std::size_t k = 0; k < word.size(); ++k)
  {
    const bool begins = k > 0 && IsUpper(word[k]) &&
      (IsLower(word[k - 1]) || (k + 1 < word.size() && IsLower(word[k + 1])));
    label += begins ? std::string(" ") + word[k] : std::string(1, word[k]);
  }
  return label;
}

/// "All Holes" for ALL_HOLES.
std::string Titled(const std::string& word)
{
  std::string label;
  for (std::size_t k = 0; k < word.size(); ++k)
  {
    const bool begins = k == 0 || word[k - 1] == '_';
    const char lower = static_cast<char>(std::tolower(static_cast<unsigned char>(word[k])));
    label += word[k] == '_' ? ' ' : (begins ? word[k] : lower);
  }
  return label;
}

/// The label for one word of a message; the word where there is none. @p isCall for a word before "()".
std::string LabelOf(const std::string& word, bool isCall)
{
  const auto found = LabelsOfClasses().find(word);
  if (found != LabelsOfClasses().end())
  {
    return found->second;
  }
  if (IsEnumerator(word))
  {
    return Titled(word);
  }
  if (!IsCamelCase(word) || IsProperName(word))
  {
    return word;
  }
  const bool isSwitch = isCall && word.size() > 2 && word.compare(word.size() - 2, 2, "On") == 0;
  return Spaced(isSwitch ? word.substr(0, word.size() - 2) : word);
}

/// True for a character beside which a word is part of a path or of something else that is the user's.
bool JoinsBefore(char c) { return c == '/' || c == '\\' || c == '\'' || c == '.' || c == '-'; }
bool JoinsAfter(const std::string& text, std::size_t at)
{
  return text[at] == '/' || text[at] == '\\' || text[at] == '\'' ||
    (text[at] == '.' && at + 1 < text.size() && IsWordCharacter(text[at + 1]));
}

/// Appends @p label to @p result, whose last word may be an article.
void AppendWithArticle(std::string& result, const std::string& label)
{
  const std::string end = result.size() >= 3 ? result.substr(result.size() - 3) : " " + result;
  if ((end == " a " || end == " A ") && std::string("AEIOU").find(label.front()) != std::string::npos)
  {
    result.insert(result.size() - 1, "n");
  }
  result += label;
}

void ReplaceAll(std::string& text, const std::string& what, const std::string& with)
{
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
  {
    text.replace(at, what.size(), with);
  }
}

std::string InWordsOfThePlace(const std::string& text)
{
#ifdef SURFACE_SYNTHESIS_PARAVIEW
  return InWordsOfParaView(text);
#else
  return text;
#endif
}
} // namespace

std::string InWordsOfParaView(const std::string& text)
{
  std::string result;
  bool quoted = false;
  for (std::size_t at = 0; at < text.size();)
  {
    quoted = quoted != (text[at] == '"');
    if (!IsWordCharacter(text[at]))
    {
      result += text[at++];
      continue;
    }
    std::size_t end = at;
    while (end < text.size() && IsWordCharacter(text[end]))
    {
      ++end;
    }
    const std::string word = text.substr(at, end - at);
    const bool joined = (at > 0 && JoinsBefore(text[at - 1])) || (end < text.size() && JoinsAfter(text, end));
    const bool isCall = text.compare(end, 2, "()") == 0;
    const std::string label = quoted || joined ? word : LabelOf(word, isCall);
    AppendWithArticle(result, label);
    at = isCall && label != word ? end + 2 : end;
  }
  ReplaceAll(result, " on port 0", " as input");
  ReplaceAll(result, " on port 1", " as second input");
  return result;
}

void ReportError(vtkAlgorithm* self, const std::string& where, const std::string& text)
{
  vtkErrorWithObjectMacro(self, << InWordsOfThePlace(where.empty() ? text : where + ": " + text));
}

void ReportWarning(vtkAlgorithm* self, const std::string& where, const std::string& text)
{
  vtkWarningWithObjectMacro(self, << InWordsOfThePlace(where.empty() ? text : where + ": " + text));
}

} // namespace surfsynth
