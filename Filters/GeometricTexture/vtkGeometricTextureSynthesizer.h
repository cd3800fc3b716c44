// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkGeometricTextureSynthesizer
 * @brief   Grows the relief of one surface on another
 *
 * A geometric texture is what distinguishes bark from scales: the fine shape of a surface, at several scales. A model
 * learns it from a single mesh and then grows it on any other ("Deep Geometric Texture Synthesis", Hertz et al. 2020).
 * At each level a network looks at every triangle and its three neighbours and displaces the points, along the surface
 * as well as off it; then every triangle is cut into four, and the next level adds finer shape. What the network sees
 * has noise on it, so that each seed grows another sample of the same texture.
 *
 * @par Model file
 * safetensors with the metadata `architecture` ("geometric_texture"), as the training of geometric textures writes it.
 * Files are checked before anything is taken from them; a file that is damaged, or is no such model, is an error that
 * says why. A file is read once, and again in an update after its size or time of modification has changed.
 *
 * @par Input
 * The target: vtkPolyData with triangles, polygons or strips, float or double points, of any genus, open or closed, any
 * number of components; or a composite dataset of such blocks, processed block by block with noise that differs between
 * blocks: a block that cannot be processed is reported and left empty. Polygons and strips are triangulated. The mesh
 * must have finite points, no degenerate triangle, no edge with more than two triangles and consistent winding; the
 * error message names what is wrong, the first offending cell or point and the filter that repairs it. Triangles should
 * be of even size and shape (TargetPreparation REMESH makes them so): the texture is as large as they are. Empty input
 * gives empty output.
 *
 * Without an input connection the texture grows on the template in the model file, at the origin, in mean edge lengths
 * of the reference of the training: samples of the reference itself.
 *
 * @par Output
 * A vtkPolyData of triangles with points of the precision of the input's. For n levels each triangle of the target
 * becomes 4^(n - 1). The target's point arrays are interpolated (floating-point arrays linearly; integers and text,
 * which are labels, from the nearest corner), each triangle has the cell arrays of the cell it comes from, field data
 * is kept. Normals, which would be those of the old surface, global ids and ghost arrays, vertices, lines and points
 * that no polygon or strip uses are left out. Added are
 *  - the point array DisplacementArrayName, float64, 3 components: where the point is minus where it would be on the
 *    bare target, world units;
 *  - the point array LevelArrayName, int: the generator level with which the point came; StartLevel for those of the
 *    target.
 *
 * With TargetPreparation REMESH the texture grows on a target that is made of the given one as vtkIsotropicRemeshFilter
 * does by default, which must then have manifold points, too: its points lie on the given surface; boundaries, creases
 * above 60 degrees and seams of point arrays other than normals are kept as curves; arrays, the mask included, are
 * carried over by the same rules as above, cell arrays from the nearest cell. Displacements are then those from the
 * remeshed target. A seam stays one: the surface is open there, as it is where a target that is not remeshed has two
 * points in one place.
 *
 * With OutputLevels the output is a vtkMultiBlockDataSet with the surface, or for a composite input a tree of surfaces,
 * after each level, in blocks that are named "Level 0", "Level 1", ...
 *
 * @par Time
 * Animation says what the time of the pipeline is. LEVELS: the number of levels that have grown, from 0, the bare
 * target, to n; between two numbers the points move along straight lines. Blocks of OutputLevels are empty while their
 * level has not begun. SEEDS: Interpolation, from 0 to 1. An update that asks for no time gives the grown texture. The
 * input is then the one that its source holds, or gives when no time is asked for.
 *
 * @par Cost
 * Linear in the number of triangles of the output, time and memory.
 * What has grown is kept: names and, once all levels are kept for it, time of the animation LEVELS cost no growth
 * again. The same seed gives the same bits for every number of threads.
 *
 * @sa vtkIsotropicRemeshFilter, vtkSurfaceRepairFilter, vtkPolyDataNormals
 */

#ifndef vtkGeometricTextureSynthesizer_h
#define vtkGeometricTextureSynthesizer_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisGeometricTextureModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class VTKSURFACESYNTHESISGEOMETRICTEXTURE_EXPORT vtkGeometricTextureSynthesizer : public vtkDataObjectAlgorithm
{
public:
  static vtkGeometricTextureSynthesizer* New();
  vtkTypeMacro(vtkGeometricTextureSynthesizer, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// What is done with the target before the texture grows.
  enum TargetPreparations
  {
    AS_IS = 0,     ///< nothing: the texture has the size that the triangles give it
    SUBDIVIDE = 1, ///< triangles are cut into four, as often as comes nearest to TextureScale
    REMESH = 2     ///< even triangles take their place, as large as TextureScale says; needs CGAL
  };

  /// What the time of the pipeline stands for.
  enum Animations
  {
    NO_ANIMATION = 0, ///< time is that of the input
    LEVELS = 1,       ///< the number of levels that have grown
    SEEDS = 2         ///< Interpolation between the noise of two seeds
  };

  ///@{
  /**
   * Path of the model file. Must be set. Default "".
   */
  void SetModelFileName(const char* name);
  vtkGetCharFromStdStringMacro(ModelFileName);
  ///@}

  ///@{
  /**
   * The generator level that works on the target as it is, at least 0; above the last level, that. Coarse levels make
   * large shapes: on a target whose shape is to stay, begin above 0. Default 0.
   */
  vtkSetClampMacro(StartLevel, int, 0, VTK_INT_MAX);
  vtkGetMacro(StartLevel, int);
  ///@}

  ///@{
  /**
   * The last generator level, at least -1; -1, or more than the model has, stands for the model's last. Default -1.
   */
  vtkSetClampMacro(EndLevel, int, -1, VTK_INT_MAX);
  vtkGetMacro(EndLevel, int);
  ///@}

  ///@{
  /**
   * The seed. Any integer; each gives other noise, and so another sample of the texture. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * The seed of the noise that Interpolation leads to. Any integer. Default 1.
   */
  vtkSetMacro(SecondSeed, int);
  vtkGetMacro(SecondSeed, int);
  ///@}

  ///@{
  /**
   * From the noise of Seed at 0 to that of SecondSeed at 1: cos(a) times the first and sin(a) times the second, a being
   * that part of a right angle, so that its variance stays. Default 0.
   */
  vtkSetClampMacro(Interpolation, double, 0.0, 1.0);
  vtkGetMacro(Interpolation, double);
  ///@}

  ///@{
  /**
   * Standard deviation of the noise on each coordinate, in mean edge lengths of a level, at least -1; below 0 stands
   * for that of the training, and 0 for no noise. Default -1.
   */
  vtkSetClampMacro(NoiseAmplitude, double, -1.0, 1e6);
  vtkGetMacro(NoiseAmplitude, double);
  ///@}

  ///@{
  /**
   * The generator levels that get no noise: numbers from 0 on between blanks or commas, as in "0 2". Default "".
   */
  void SetLevelsWithoutNoise(const char* name);
  vtkGetCharFromStdStringMacro(LevelsWithoutNoise);
  ///@}

  ///@{
  /**
   * What is done with the target before the texture grows. Default AS_IS.
   */
  vtkSetClampMacro(TargetPreparation, int, AS_IS, REMESH);
  vtkGetMacro(TargetPreparation, int);
  void SetTargetPreparationToAsIs() { this->SetTargetPreparation(AS_IS); }
  void SetTargetPreparationToSubdivide() { this->SetTargetPreparation(SUBDIVIDE); }
  void SetTargetPreparationToRemesh() { this->SetTargetPreparation(REMESH); }
  ///@}

  ///@{
  /**
   * Size of the texture over that on the target as it is, from 0.001 to 1000; used with SUBDIVIDE and REMESH. Each
   * subdivision of the target halves it, so that 0.5 and 0.25 are met exactly and others by the nearest power of a
   * half; 1 and above leave the target as it is. A remeshed target has so many times the mean edge length of the
   * target, within 2 per cent where its shape, boundaries and creases allow it: 1 makes triangles even; above 1 the
   * texture gets larger, and the shape of the target coarser. Default 1.
   */
  vtkSetClampMacro(TextureScale, double, 0.001, 1000.0);
  vtkGetMacro(TextureScale, double);
  ///@}

  ///@{
  /**
   * Name of a point array of the target with one component, from 0 to 1, that displacements are multiplied with: the
   * texture grows where it is 1, and where it is 0 points stay where they are. Not used without input. Default "": it
   * grows everywhere.
   */
  void SetMaskArrayName(const char* name);
  vtkGetCharFromStdStringMacro(MaskArrayName);
  ///@}

  ///@{
  /**
   * Distance from points whose mask is 0 over which the texture rises to its full strength, along edges of the target,
   * in world units, at least 0. Default 0: the values of the mask alone count.
   */
  vtkSetClampMacro(MaskFalloff, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(MaskFalloff, double);
  ///@}

  ///@{
  /**
   * Without input: the first generator level with noise of the seed, at least 0; below it the noise is what
   * reconstructs the reference of the training, so that large shapes are those of the reference. More than the model's
   * levels stands for the reconstruction itself. Default 0.
   */
  vtkSetClampMacro(RandomFromLevel, int, 0, VTK_INT_MAX);
  vtkGetMacro(RandomFromLevel, int);
  ///@}

  ///@{
  /**
   * Whether the output is a multi-block dataset with the surface after each level. Default off.
   */
  vtkSetMacro(OutputLevels, bool);
  vtkGetMacro(OutputLevels, bool);
  vtkBooleanMacro(OutputLevels, bool);
  ///@}

  ///@{
  /**
   * What the time of the pipeline stands for. Default NO_ANIMATION.
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
   * Name of the point array with the level with which each point came; not empty. Default "Level".
   */
  void SetLevelArrayName(const char* name);
  vtkGetCharFromStdStringMacro(LevelArrayName);
  ///@}

  /**
   * One line about the model of the last update: its name, levels and channels. Empty before there is one.
   */
  std::string GetModelDescription() const;

  /**
   * Number of model files read since this object was made. Stays the same while the file does.
   */
  vtkTypeInt64 GetNumberOfModelLoads() const;

  /**
   * Number of textures grown since this object was made. Stays the same while only names or the time of an animation of
   * levels change.
   */
  vtkTypeInt64 GetNumberOfSyntheses() const;

  /**
   * Number of targets remeshed since this object was made. Stays the same while a target, the seams of its arrays and
   * TextureScale do.
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

  void SetText(std::string& property, const char* text);

  /// Fills the output from the dataset of @p targets; false after an error.
  bool Synthesize(vtkInformationVector* targets, vtkInformationVector* outputVector);

  std::string ModelFileName;
  int StartLevel = 0;
  int EndLevel = -1;
  int Seed = 0;
  int SecondSeed = 1;
  double Interpolation = 0.0;
  double NoiseAmplitude = -1.0;
  std::string LevelsWithoutNoise;
  int TargetPreparation = AS_IS;
  double TextureScale = 1.0;
  std::string MaskArrayName;
  double MaskFalloff = 0.0;
  int RandomFromLevel = 0;
  bool OutputLevels = false;
  int Animation = NO_ANIMATION;
  std::string DisplacementArrayName = "Displacement";
  std::string LevelArrayName = "Level";

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
