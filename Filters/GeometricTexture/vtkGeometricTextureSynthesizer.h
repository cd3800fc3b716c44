// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkGeometricTextureSynthesizer
 * @brief   Synthesizes the geometric texture of one surface on another
 *
 * A geometric texture is the fine shape of a surface, at several scales: of bark, for instance, or of reptile scales. A
 * model learns it from a single mesh and synthesizes it on any other [Hertz2020]. At each level a network computes
 * displacements of the points, tangential and normal, from every triangle and its three neighbours. Then every triangle
 * is divided into four, and the next level adds finer shape. The input of the network has noise, so that each seed
 * gives a different sample of the same texture.
 *
 * @par Model file
 * safetensors with the metadata `architecture` ("geometric_texture"), as the training of geometric textures writes it.
 * Files are checked before use; a damaged file, or one without such a model, is an error that names the cause. A file
 * is read once, and again in an update after its size or time of modification has changed. Published checkpoints become
 * model files, without template and statistics, by convert_checkpoint() of the Python package.
 *
 * @par Input
 * The target: vtkPolyData with triangles, polygons or strips, float or double points, of any genus, open or closed, any
 * number of components; or a composite dataset of such blocks, processed block by block with noise that differs between
 * blocks: a block that cannot be processed is reported and left empty. Polygons and strips are triangulated. The mesh
 * must have finite points, no degenerate triangle, no edge with more than two triangles and consistent winding; the
 * error message names the defect, the first offending cell or point and the filter that repairs it. Triangles should
 * be of even size and shape (see TargetPreparation REMESH): their size sets that of the texture. Empty input gives
 * empty output.
 *
 * Without an input connection the target is the template in the model file, at the origin, in mean edge lengths of the
 * reference of the training: the results are samples of the reference itself.
 *
 * @par Output
 * A vtkPolyData of triangles with points of the precision of the input's. For n levels each triangle of the target
 * becomes 4^(n - 1) triangles. The target's point arrays are interpolated (floating-point arrays linearly; integers and
 * text, which are labels, from the nearest corner), each triangle has the cell arrays of the cell it comes from, field
 * data is kept. Normals, global ids and ghost arrays, vertices, lines and points that no polygon or strip uses are left
 * out. Added are
 *  - the point array DisplacementArrayName, float64, 3 components: the position of the point minus that on the target
 *    without texture, world units;
 *  - the point array LevelArrayName, int: the generator level that added the point; StartLevel for the points of the
 *    target.
 *
 * With TargetPreparation REMESH the target is first remeshed as by vtkIsotropicRemeshFilter with its defaults, and must
 * then have manifold points, too. Points of the remeshed target lie on the given surface; boundaries, creases above 60
 * degrees and seams of point arrays other than normals are kept as curves; arrays, the mask included, are transferred
 * by the same rules as above, cell arrays from the nearest cell. Displacements are then those from the remeshed target.
 * A seam remains: the surface is open there, as at coincident points of a target that is not remeshed.
 *
 * With OutputLevels the output is a vtkMultiBlockDataSet with the surface, or for a composite input a tree of surfaces,
 * after each level, in blocks that are named "Level 0", "Level 1", ...
 *
 * @par Time
 * Animation chooses the meaning of the time of the pipeline. LEVELS: the number of finished levels, from 0, the target
 * without texture, to n; between two numbers the points move along straight lines. Blocks of OutputLevels are empty
 * until their level begins. SEEDS: Interpolation, from 0 to 1. An update without a requested time outputs the finished
 * texture. The input is then the one that its source holds, or outputs without a requested time.
 *
 * @par Cost
 * Linear in the number of triangles of the output, time and memory. Results are kept: a change of names, of Strength and
 * Printable and, once all levels are kept for it, of the time of the animation LEVELS costs no synthesis. Printable searches
 * for triangles that intersect, in n log n time: two to five times the time of the synthesis with one thread, 4 to 10
 * microseconds for a triangle, and more where many intersect. With Printable each change of Strength costs that again. The
 * same seed gives the same bits for every number of threads.
 * Another kind of processor may give other last bits: Reproducibility in README.md.
 *
 * @sa vtkIsotropicRemeshFilter, vtkSurfaceRepairFilter, vtkPolyDataNormals
 */

#ifndef vtkGeometricTextureSynthesizer_h
#define vtkGeometricTextureSynthesizer_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkDeprecation.h"                            // For VTK_DEPRECATION
#include "vtkSurfaceSynthesisGeometricTextureModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class vtkStringArray;

class VTKSURFACESYNTHESISGEOMETRICTEXTURE_EXPORT vtkGeometricTextureSynthesizer : public vtkDataObjectAlgorithm
{
public:
  static vtkGeometricTextureSynthesizer* New();
  vtkTypeMacro(vtkGeometricTextureSynthesizer, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Preparations of the target before the synthesis.
  enum TargetPreparations
  {
    AS_IS = 0,     ///< none: the size of the triangles sets that of the texture
    SUBDIVIDE = 1, ///< division of triangles into four, as often as is nearest to TextureScale
    REMESH = 2     ///< remeshing with even triangles, of the size that TextureScale sets; needs CGAL
  };

  /// Statistics that normalize the channels of the networks.
  enum NormStatisticsChoices
  {
    TARGET = 0,   ///< those on the target, as published
    REFERENCE = 1 ///< those on the reference of the training, which the model file holds
  };

  /// Meanings of the time of the pipeline.
  enum Animations
  {
    NO_ANIMATION = 0, ///< time is that of the input
    LEVELS = 1,       ///< the number of finished levels
    SEEDS = 2         ///< Interpolation between the noise of two seeds
  };

  ///@{
  /**
   * Path of the model file, or name of an installed model (GetInstalledModels()). Must be set. Default "".
   */
  void SetModelFileName(const char* name);
  vtkGetCharFromStdStringMacro(ModelFileName);
  ///@}

  /**
   * Names of the installed models that suit this filter.
   */
  vtkStringArray* GetInstalledModels();

  /**
   * Folder of the installed models; empty without one.
   */
  const char* GetInstalledModelsFolder() const;

  ///@{
  /**
   * Generator level that works on the target at its own resolution, at least -1; one above the last level is an error
   * that names the levels. Coarse levels make large shapes: begin above 0 to keep the shape of the target. -1 stands for
   * level 1 on a target, or for the last level where that is 0, and for level 0 without input. Default 0.
   */
  vtkSetClampMacro(StartLevel, int, -1, VTK_INT_MAX);
  vtkGetMacro(StartLevel, int);
  ///@}

  ///@{
  /**
   * Last generator level, at least -1; -1 and values above the last level stand for the last level of the model.
   * Default -1.
   */
  vtkSetClampMacro(EndLevel, int, -1, VTK_INT_MAX);
  vtkGetMacro(EndLevel, int);
  ///@}

  ///@{
  /**
   * Seed of the random numbers, any integer. Each seed gives a different sample of the texture. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Seed of the noise at Interpolation 1, any integer. Default 1.
   */
  vtkSetMacro(SecondSeed, int);
  vtkGetMacro(SecondSeed, int);
  ///@}

  ///@{
  /**
   * Interpolation from 0, the noise of Seed, to 1, that of SecondSeed: cos(a) times the first plus sin(a) times the
   * second, with a = Interpolation pi / 2, so that the variance is constant. Default 0.
   */
  vtkSetClampMacro(Interpolation, double, 0.0, 1.0);
  vtkGetMacro(Interpolation, double);
  ///@}

  ///@{
  /**
   * Standard deviation of the noise on each coordinate, in mean edge lengths of a level, at least -1; values below 0
   * stand for that of the training, and 0 for no noise. Default -1.
   */
  vtkSetClampMacro(NoiseAmplitude, double, -1.0, 1e6);
  vtkGetMacro(NoiseAmplitude, double);
  ///@}

  ///@{
  /**
   * Restarts of a flow at each level, from 0 to 20, or -1 for 3. At the end of the flow the displacements are mixed with
   * fresh noise as at half of its time, and go on from there again [Xu2023]: that mends errors of the first part, as
   * features that are too close to each other. Each takes half of the time of the flow itself. Not used by models that are
   * no flows (Objective of vtkGeometricTextureTrainer). Default -1.
   */
  vtkSetClampMacro(NumberOfRestarts, int, -1, 20);
  vtkGetMacro(NumberOfRestarts, int);
  ///@}

  ///@{
  /**
   * Statistics that normalize the channels of the networks. TARGET: means and variances over the whole target, as
   * published; they suit targets that are curved otherwise than the reference. REFERENCE: means and variances on samples
   * of the reference, which the training writes into the model file, of a flow for each of its steps; the texture at a
   * point depends on the target nearby alone, so that another component changes nothing and a growing part nothing far
   * away, and no network sees the mask, which fades the result: where it is 1 the texture is that without it. A model
   * without them is an error then: WriteModelWithStatistics() adds them. Default TARGET.
   */
  vtkSetClampMacro(NormStatistics, int, TARGET, REFERENCE);
  vtkGetMacro(NormStatistics, int);
  void SetNormStatisticsToTarget() { this->SetNormStatistics(TARGET); }
  void SetNormStatisticsToReference() { this->SetNormStatistics(REFERENCE); }
  ///@}

  ///@{
  /**
   * Generator levels without noise: numbers from 0 on, separated by blanks or commas, as in "0 2". Default "".
   */
  void SetLevelsWithoutNoise(const char* name);
  vtkGetCharFromStdStringMacro(LevelsWithoutNoise);
  ///@}

  ///@{
  /**
   * Preparation of the target before the synthesis. Default AS_IS.
   */
  vtkSetClampMacro(TargetPreparation, int, AS_IS, REMESH);
  vtkGetMacro(TargetPreparation, int);
  void SetTargetPreparationToAsIs() { this->SetTargetPreparation(AS_IS); }
  void SetTargetPreparationToSubdivide() { this->SetTargetPreparation(SUBDIVIDE); }
  void SetTargetPreparationToRemesh() { this->SetTargetPreparation(REMESH); }
  ///@}

  ///@{
  /**
   * Ratio of the size of the texture to that on the unprepared target, from 0.001 to 1000, or 0; used with SUBDIVIDE and
   * REMESH. Each subdivision of the target halves it: 0.5 and 0.25 are met exactly, other values by the nearest power
   * of a half; 1 and above leave the target unchanged. Remeshing multiplies the mean edge length of the target by it,
   * within 2 per cent where shape, boundaries and creases allow it: 1 makes triangles even; above 1 the texture gets
   * larger, and the shape of the target coarser. 0 chooses it so that about 7000 triangles begin the synthesis, which
   * carry a shape with limbs and the texture on it; values between 0 and 0.001 stand for 0.001. Default 1.
   */
  vtkSetClampMacro(TextureScale, double, 0.0, 1000.0);
  vtkGetMacro(TextureScale, double);
  ///@}

  ///@{
  /**
   * Name of a point array of the target with one component, from 0.01 to 100, that multiplies the size of the texture from
   * place to place: the length of the edges of the remeshed target, about TextureScale times the mean edge length of the
   * target times the array, and the units of the networks. Sizes should change little over the length of some edges. Used with
   * REMESH. Default "": one size.
   */
  void SetSizeArrayName(const char* name);
  vtkGetCharFromStdStringMacro(SizeArrayName);
  ///@}

  ///@{
  /**
   * Name of a point array of the target with one component, from 0 to 1, the factor of displacements: full texture at
   * 1, none at 0. Not used without input. Default "": full texture everywhere.
   */
  void SetMaskArrayName(const char* name);
  vtkGetCharFromStdStringMacro(MaskArrayName);
  ///@}

  ///@{
  /**
   * Distance from points with mask 0 over which the texture rises to its full strength, along edges of the target, in
   * world units, at least 0. Default 0: only the mask counts.
   */
  vtkSetClampMacro(MaskFalloff, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(MaskFalloff, double);
  ///@}

  ///@{
  /**
   * Path of a second model file, or name of an installed model, with as many levels as the first; not used without input. At
   * each level both networks take the same mesh and the same noise, and points move by (1 - w) times the displacement of the
   * first plus w times that of the second, where w is the array of BlendArrayName: where it is 0 everywhere, or 1 everywhere,
   * the texture is that of one model. Takes twice the time. Default "": one model.
   */
  void SetSecondModelFileName(const char* name);
  vtkGetCharFromStdStringMacro(SecondModelFileName);
  ///@}

  ///@{
  /**
   * Name of a point array of the target with one component, from 0, the texture of ModelFileName, to 1, that of
   * SecondModelFileName, linear between points. Must be set with SecondModelFileName. Default "".
   */
  void SetBlendArrayName(const char* name);
  vtkGetCharFromStdStringMacro(BlendArrayName);
  ///@}

  ///@{
  /**
   * Factor of the displacements of the synthesized texture, from 0 to 1e6: points lie at b + s d, where b is their place on
   * the target without texture, d the displacement with the mask, and s the product of Strength and the array of
   * StrengthArrayName. The networks see the texture without it, so that its pattern stays, above 1 too; with
   * NormStatistics TARGET the mask and MaskFalloff are part of what they see. Printable reduces the result. Default 1.
   */
  vtkSetClampMacro(Strength, double, 0.0, 1e6);
  vtkGetMacro(Strength, double);
  ///@}

  ///@{
  /**
   * Name of a point array of the target with one component, from 0 to 1e6, that Strength is multiplied with, linear between
   * points. Not used without input. Default "": 1 everywhere.
   */
  void SetStrengthArrayName(const char* name);
  vtkGetCharFromStdStringMacro(StrengthArrayName);
  ///@}

  ///@{
  /**
   * Reduces displacements until no triangles of the output intersect, for slicers of 3D printers; needs CGAL. Around
   * triangles that intersect, first the tangential part of the displacements falls, then the part along the normals of the
   * target, by a quarter at a time, which fades over about twice their length. The points in single precision, as STL files
   * hold them, are tested, too. Where triangles of the target itself intersect they remain, with a warning:
   * GetNumberOfSelfIntersections(). With OutputLevels each level is made so by itself; between the levels of an animation
   * triangles may intersect. Default off.
   */
  vtkSetMacro(Printable, bool);
  vtkGetMacro(Printable, bool);
  vtkBooleanMacro(Printable, bool);
  ///@}

  ///@{
  /**
   * First generator level with noise of the seed, at least 0, without input. Below it the noise is that which
   * reconstructs the reference of the training, so that large shapes are those of the reference. Values above the last
   * level stand for the reconstruction itself. Must be 0 with a flow, which does not reconstruct. Default 0.
   */
  vtkSetClampMacro(RandomFromLevel, int, 0, VTK_INT_MAX);
  vtkGetMacro(RandomFromLevel, int);
  ///@}

  ///@{
  /**
   * Makes the output a multi-block dataset with the surface after each level. Default off.
   */
  vtkSetMacro(OutputLevels, bool);
  vtkGetMacro(OutputLevels, bool);
  vtkBooleanMacro(OutputLevels, bool);
  ///@}

  ///@{
  /**
   * Meaning of the time of the pipeline. Default NO_ANIMATION.
   */
  vtkSetClampMacro(Animation, int, NO_ANIMATION, SEEDS);
  vtkGetMacro(Animation, int);
  void SetAnimationToNoAnimation() { this->SetAnimation(NO_ANIMATION); }
  void SetAnimationToLevels() { this->SetAnimation(LEVELS); }
  void SetAnimationToSeeds() { this->SetAnimation(SEEDS); }
  ///@}

  ///@{
  /**
   * Name of the point array with the displacement of each point; not empty. Default "Displacement".
   */
  void SetDisplacementArrayName(const char* name);
  vtkGetCharFromStdStringMacro(DisplacementArrayName);
  ///@}

  ///@{
  /**
   * Name of the point array with the level that added each point; not empty. Default "Level".
   */
  void SetLevelArrayName(const char* name);
  vtkGetCharFromStdStringMacro(LevelArrayName);
  ///@}

  /**
   * Writes the model of ModelFileName to another file, with the statistics for REFERENCE measured on @p samples random
   * samples of its template, 1 to 1000: for models of earlier versions, and converted ones. The same model gives the same
   * file. Returns false after an error, which is reported: no model, a model without a template, a file that cannot be
   * written.
   */
  bool WriteModelWithStatistics(const char* fileName, int samples = 8);

  /**
   * Number of pairs of triangles that still intersect in the last update with Printable, where those of the target do; -1
   * after one without. Of the finest level that the output has, in all blocks.
   */
  vtkTypeInt64 GetNumberOfSelfIntersections() const;

  /**
   * Share of the height of the texture that Printable has kept in the last update, 0 to 1: the integral of the absolute
   * displacement along the normals of the target, over the same before; 1 without Printable. Of the finest level that the
   * output has, in all blocks.
   */
  double GetHeightKept() const;

  /**
   * Description of the model of the last update in one line: name, levels and channels. Empty before the first model.
   */
  std::string GetModelDescription() const;

  /**
   * Number of model files read since this object was made. Unchanged while the file is unchanged.
   */
  vtkTypeInt64 GetNumberOfModelLoads() const;

  /**
   * Number of textures synthesized since this object was made. Unchanged while only names, Strength, Printable or the
   * time of an animation of levels change.
   */
  vtkTypeInt64 GetNumberOfSyntheses() const;

  /**
   * Former name of GetNumberOfSyntheses().
   */
  VTK_DEPRECATION("Use GetNumberOfSyntheses()")
  vtkTypeInt64 GetNumberOfGrowths() const { return this->GetNumberOfSyntheses(); }

  /**
   * Number of targets remeshed since this object was made. Unchanged while the target, the seams of its arrays and
   * TextureScale are.
   */
  vtkTypeInt64 GetNumberOfRemeshings() const;

protected:
  vtkGeometricTextureSynthesizer();
  ~vtkGeometricTextureSynthesizer() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkGeometricTextureSynthesizer(const vtkGeometricTextureSynthesizer&) = delete;
  void operator=(const vtkGeometricTextureSynthesizer&) = delete;

  /// Fills the output from the dataset of @p targets; false after an error.
  bool Synthesize(vtkInformationVector* targets, vtkInformationVector* outputVector);

  std::string ModelFileName;
  int StartLevel = 0;
  int EndLevel = -1;
  int Seed = 0;
  int SecondSeed = 1;
  double Interpolation = 0.0;
  double NoiseAmplitude = -1.0;
  int NumberOfRestarts = -1;
  int NormStatistics = TARGET;
  std::string LevelsWithoutNoise;
  int TargetPreparation = AS_IS;
  double TextureScale = 1.0;
  std::string SizeArrayName;
  std::string MaskArrayName;
  double MaskFalloff = 0.0;
  std::string SecondModelFileName;
  std::string BlendArrayName;
  double Strength = 1.0;
  std::string StrengthArrayName;
  bool Printable = false;
  int RandomFromLevel = 0;
  bool OutputLevels = false;
  int Animation = NO_ANIMATION;
  std::string DisplacementArrayName = "Displacement";
  std::string LevelArrayName = "Level";

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
