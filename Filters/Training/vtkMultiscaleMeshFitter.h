// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMultiscaleMeshFitter
 * @brief   Makes meshes of one surface at several scales
 *
 * Geometric textures are learnt from one surface as meshes at several scales, each with the triangles of the one before
 * cut into four. This filter makes them of any surface ("Deep Geometric Texture Synthesis", Hertz et al.
 * 2020, section 4): a template of the same topology is fitted to it by Adam, in turns by steps that keep triangles even
 * and by steps that bring random samples of both surfaces, and their normals, closer; then it is subdivided at the
 * midpoints of its edges, fitted again, and so on.
 *
 * The template SURFACE is made from the reference: points of its smooth form [Lee1998] [Liu2020] that successive half-edge
 * collapses leave, which keep topology and boundaries and map the template onto the reference one to one. The finest level is
 * placed by that map, relaxed along the reference, boundaries along boundaries, and smoothed where triangles fold; coarser
 * levels have the points that they share with it. No Adam, therefore steps, learning rates, Samples, PublishedNormals and Seed
 * play no part.
 *
 * @par Input
 * Port 0: the reference, vtkPolyData with triangles, polygons or strips of finite points and none of them degenerate.
 * It need not be manifold, closed or of one component, but only surfaces with the topology of the template are fitted
 * well; for the template SURFACE it has manifold edges and points, consistent winding and any topology. Port 1, for the
 * template GIVEN: the template, vtkPolyData with manifold edges and consistent winding, wound as the reference is. An empty
 * reference gives empty outputs and no error.
 *
 * @par Output
 * Port 0: a vtkMultiBlockDataSet with a vtkPolyData of triangles with double-precision points for each level, coarse to
 * fine, in blocks that are named "Level 0", "Level 1", ..., in the coordinates of the reference. Each has field
 * arrays of one value: "MeanDistance" and "LargestDistance", of its points from the reference, world units;
 * "SymmetricMeanDistance" and "SymmetricPercentile95", of 20,000 samples on each of both surfaces from the other one, world
 * units; "MeanNormalAngle", of the normals at such samples, degrees; and in builds with CGAL "NumberOfSelfIntersections",
 * pairs of triangles that intersect in more than points and edges that both share.
 * Port 1: the template as the fit began with it, moved and scaled to the box of the reference (but for SURFACE, which lies in
 * place), with the triangles of level 0: the template of vtkGeometricTextureTrainer. Port 2: the finest level by itself, for
 * the eye.
 *
 * @par Cost
 * Iterations x NumberOfLevels x (TriangulationSteps + ChamferSteps) steps, each over all vertices and Samples x
 * (level + 1) samples: with the defaults a few minutes. The recipe of the paper, 3000 iterations with a LearningRate of
 * 1e-4 and a LearningRateDecay of 1, takes ten times as long. The template SURFACE takes Iterations rounds over the vertices of
 * the finest level, each with a search for the nearest place: a minute for 81,920 triangles. The same seed gives the same meshes
 * on the same machine with the same number of threads, unless the TimeBudget ends a level. ParaView before 6.2 cannot abort an
 * update: give it a TimeBudget or Background there.
 *
 * @sa vtkGeometricTextureSynthesizer, vtkIsotropicRemeshFilter
 */

#ifndef vtkMultiscaleMeshFitter_h
#define vtkMultiscaleMeshFitter_h

#include "vtkMultiBlockDataSetAlgorithm.h"
#include "vtkSurfaceSynthesisTrainingModule.h" // For export macro

#include <limits> // For std::numeric_limits
#include <memory> // For std::unique_ptr
#include <string> // For std::string

class VTKSURFACESYNTHESISTRAINING_EXPORT vtkMultiscaleMeshFitter : public vtkMultiBlockDataSetAlgorithm
{
public:
  static vtkMultiscaleMeshFitter* New();
  vtkTypeMacro(vtkMultiscaleMeshFitter, vtkMultiBlockDataSetAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The mesh that is fitted.
  enum Templates
  {
    ICOSPHERE = 0, ///< for surfaces of genus 0
    TORUS = 1,     ///< for surfaces of genus 1, around the z axis
    GIVEN = 2,     ///< the mesh on port 1
    SURFACE = 3    ///< the reference, smoothed and simplified: any topology, with or without boundary
  };

  ///@{
  /**
   * Number of levels, from 1 to 10; each has four times the triangles of the one before. Default 5.
   */
  vtkSetClampMacro(NumberOfLevels, int, 1, 10);
  vtkGetMacro(NumberOfLevels, int);
  ///@}

  ///@{
  /**
   * Mesh that is fitted: of the topology of the reference, and wound as it is. Default ICOSPHERE.
   */
  vtkSetClampMacro(Template, int, ICOSPHERE, SURFACE);
  vtkGetMacro(Template, int);
  void SetTemplateToIcosphere() { this->SetTemplate(ICOSPHERE); }
  void SetTemplateToTorus() { this->SetTemplate(TORUS); }
  void SetTemplateToGiven() { this->SetTemplate(GIVEN); }
  void SetTemplateToSurface() { this->SetTemplate(SURFACE); }
  ///@}

  ///@{
  /**
   * Number of times that the triangles of the icosahedron are cut into four for the template ICOSPHERE, from 0 to 6. Default 2.
   */
  vtkSetClampMacro(IcosphereLevel, int, 0, 6);
  vtkGetMacro(IcosphereLevel, int);
  ///@}

  ///@{
  /**
   * Pairs of triangles around the axis of the template TORUS, from 3 to 1000; around its tube there are a third as
   * many, but at least 3. Default 24.
   */
  vtkSetClampMacro(TorusSegments, int, 3, 1000);
  vtkGetMacro(TorusSegments, int);
  ///@}

  ///@{
  /**
   * Number of triangles of the template SURFACE, from 4 to 1000000: at most so many, or as few as the topology allows.
   * Default 320.
   */
  vtkSetClampMacro(TemplateTriangles, int, 4, 1000000);
  vtkGetMacro(TemplateTriangles, int);
  ///@}

  ///@{
  /**
   * Length that the template SURFACE is smoothed with, world units, at least 0: of waves of this length 5 percent are left, of
   * waves ten times as long 94 percent; 0 for half of the mean edge length of the template. Default 0.
   */
  vtkSetClampMacro(SmoothingLength, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(SmoothingLength, double);
  ///@}

  ///@{
  /**
   * Number of iterations at each level, from 0 to 1000000; for the template SURFACE number of rounds of relaxation of the
   * finest level. Default 300.
   */
  vtkSetClampMacro(Iterations, int, 0, 1000000);
  vtkGetMacro(Iterations, int);
  ///@}

  ///@{
  /**
   * Steps in each iteration that keep triangles even, from 0 to 1000. Default 3.
   */
  vtkSetClampMacro(TriangulationSteps, int, 0, 1000);
  vtkGetMacro(TriangulationSteps, int);
  ///@}

  ///@{
  /**
   * Steps in each iteration that bring the surfaces closer, from 0 to 1000. Default 2.
   */
  vtkSetClampMacro(ChamferSteps, int, 0, 1000);
  vtkGetMacro(ChamferSteps, int);
  ///@}

  ///@{
  /**
   * Learning rate of Adam at the first iteration of each level, in mean edge lengths of the template, halved with
   * each level as those are; larger than 0. Default 1e-2.
   */
  vtkSetClampMacro(LearningRate, double, 1e-300, std::numeric_limits<double>::max());
  vtkGetMacro(LearningRate, double);
  ///@}

  ///@{
  /**
   * Learning rate of a level's last iteration over that of its first, from 1e-6 to 1; it falls geometrically. 1
   * keeps it as it is, as published. Default 0.1.
   */
  vtkSetClampMacro(LearningRateDecay, double, 1e-6, 1.0);
  vtkGetMacro(LearningRateDecay, double);
  ///@}

  ///@{
  /**
   * Number of samples on each surface at level 0, from 1 to 1000000; at level l there are l + 1 times as many. Default
   * 3000.
   */
  vtkSetClampMacro(Samples, int, 1, 1000000);
  vtkGetMacro(Samples, int);
  ///@}

  ///@{
  /**
   * Comparison of normals as in the published code, which pairs unrelated ones in one of the two directions. For
   * comparison. Default off.
   */
  vtkSetMacro(PublishedNormals, bool);
  vtkGetMacro(PublishedNormals, bool);
  vtkBooleanMacro(PublishedNormals, bool);
  ///@}

  ///@{
  /**
   * Seed of the samples. Any integer. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Time budget of an update in minutes, at least 0; 0 for no limit. Each level has its share of it, in which the learning
   * rate falls as it would over all iterations; a level that it ends before its last iteration is coarser, and a warning
   * says how many iterations were done and the time that all of them take. With a budget that ends a level the meshes
   * depend on the speed of the machine. Default 0.
   */
  vtkSetClampMacro(TimeBudget, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(TimeBudget, double);
  ///@}

  ///@{
  /**
   * Fit in the background: an update starts it on a thread of its own and returns at once with empty outputs; later updates
   * (Modified() and Update(), in ParaView Execute Again) give its meshes when it has ended, and nothing before. The update
   * after that starts again. StopBackground() stops it, and so do the end of this object and an update without Background.
   * Changed properties and inputs count from the next start on. Default off.
   */
  vtkSetMacro(Background, bool);
  vtkGetMacro(Background, bool);
  vtkBooleanMacro(Background, bool);
  ///@}

  /**
   * Stops a fit in the background within one iteration, without meshes: a TimeBudget ends it with those so far. Does nothing
   * without such a fit.
   */
  void StopBackground();

  /**
   * State of the fit in the background, as it is now: empty without one, else "running: ", "finished: ", "stopped: " or
   * "failed: " with the part that is done and the remaining time.
   */
  const char* GetBackgroundState() const;

  ///@{
  /**
   * Path of a dataset file that levels and template are written to, in safetensors format, for training without VTK.
   * Default "": none.
   */
  void SetDatasetFileName(const char* name);
  vtkGetCharFromStdStringMacro(DatasetFileName);
  ///@}

  ///@{
  /**
   * Removes the reference, or the template: for ParaView, which cannot name a port in doing so.
   */
  void RemoveReference() { this->SetInputConnection(0, nullptr); }
  void RemoveTemplate() { this->SetInputConnection(1, nullptr); }
  ///@}

protected:
  vtkMultiscaleMeshFitter();
  ~vtkMultiscaleMeshFitter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkMultiscaleMeshFitter(const vtkMultiscaleMeshFitter&) = delete;
  void operator=(const vtkMultiscaleMeshFitter&) = delete;

  class BackgroundFit;
  class Internals;

  int NumberOfLevels = 5;
  int Template = ICOSPHERE;
  int IcosphereLevel = 2;
  int TorusSegments = 24;
  int TemplateTriangles = 320;
  double SmoothingLength = 0.0;
  int Iterations = 300;
  int TriangulationSteps = 3;
  int ChamferSteps = 2;
  double LearningRate = 1e-2;
  double LearningRateDecay = 0.1;
  int Samples = 3000;
  bool PublishedNormals = false;
  int Seed = 0;
  double TimeBudget = 0.0;
  bool Background = false;
  std::string DatasetFileName;
  mutable std::string BackgroundState;
  std::unique_ptr<BackgroundFit> Task;
};

#endif
