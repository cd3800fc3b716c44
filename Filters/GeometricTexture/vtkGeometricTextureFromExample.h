// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkGeometricTextureFromExample
 * @brief   Synthesizes the geometric texture of an example surface on another, without a training
 *
 * A geometric texture is the fine shape of a surface: scales, spikes, bark, fur. This filter needs no model file: it finds
 * displacements of the target whose patches, pieces of the surface a few features wide, look like those of the example. From
 * coarse scales to fine ones it first matches the distribution of the patches, by sliced Wasserstein distances
 * [Heitz2021], [Elnekave2022], and then replaces each patch by the nearest one of the example, and overlapping patches by
 * their mean, in which patches count less the less they agree [Kwatra2005], [Granot2022]; it stretches the mean until patches
 * vary as widely as those of the example. Patches follow geodesics and hold vectors in tangent frames, so that overhangs are
 * followed and the triangulations of example and target do not matter.
 *
 * @par Input
 * Port 0: the target, vtkPolyData with triangles, polygons or strips, of any genus, open or closed; or a composite dataset
 * of such blocks, processed block by block with random numbers that differ between blocks. The mesh must have finite
 * points, no degenerate triangle, no edge with more than two triangles and consistent winding; the error message names the
 * defect, the first offending cell or point and the filter that repairs it. Empty input gives empty output.
 * @par
 * Port 1, optional: the example, a vtkPolyData as for port 0, such as a piece of a scan. Without it that of ExampleFileName.
 * @par
 * Port 2, optional: the example without its texture, with the same triangles. Without it that is the smooth form of the
 * example: see SmoothingLength.
 * @par
 * Port 3, optional: a second example, for a blend of two textures: see BlendArrayName; without it that of
 * SecondExampleFileName. Port 4, optional: the second example without its texture, as on port 2.
 *
 * @par Output
 * A vtkPolyData of triangles with points of the precision of the input's: the target, with each triangle divided into four
 * GetSubdivisionsUsed() times, and displaced. Point arrays of the target are interpolated, cell arrays copied and field data
 * kept, as by vtkGeometricTextureSynthesizer. Added is the point array DisplacementArrayName, float64, 3 components: the
 * position of the point minus that on the target without texture, world units.
 *
 * @par Cost
 * Linear in the number of triangles of the output: see Testing/Benchmarks/README.md. The patches of the examples are kept, up
 * to 150 MB for a scale of each, and a change of Strength, Printable, MaskArrayName or DisplacementArrayName costs no
 * synthesis. Printable searches for triangles that intersect, in each update: 4 to 10 microseconds for a triangle, and more
 * where many intersect. The same seed gives the same bits for every
 * number of threads. Another kind of processor may give other last bits: Reproducibility in README.md.
 *
 * @sa vtkGeometricTextureSynthesizer, vtkDisplacementMapFilter, vtkGeometricTextureFeatures, vtkIsotropicRemeshFilter
 */

#ifndef vtkGeometricTextureFromExample_h
#define vtkGeometricTextureFromExample_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisGeometricTextureModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class vtkStringArray;

class VTKSURFACESYNTHESISGEOMETRICTEXTURE_EXPORT vtkGeometricTextureFromExample : public vtkDataObjectAlgorithm
{
public:
  static vtkGeometricTextureFromExample* New();
  vtkTypeMacro(vtkGeometricTextureFromExample, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Example of port 1.
   */
  void SetExampleConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(1, output); }
  void SetExampleData(vtkDataObject* example) { this->SetInputDataObject(1, example); }
  ///@}

  ///@{
  /**
   * Example without its texture, of port 2: the same triangles, other points.
   */
  void SetPlainExampleConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(2, output); }
  void SetPlainExampleData(vtkDataObject* example) { this->SetInputDataObject(2, example); }
  ///@}

  ///@{
  /**
   * Second example, of port 3.
   */
  void SetSecondExampleConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(3, output); }
  void SetSecondExampleData(vtkDataObject* example) { this->SetInputDataObject(3, example); }
  ///@}

  ///@{
  /**
   * Second example without its texture, of port 4: the same triangles, other points.
   */
  void SetSecondPlainExampleConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(4, output); }
  void SetSecondPlainExampleData(vtkDataObject* example) { this->SetInputDataObject(4, example); }
  ///@}

  ///@{
  /**
   * Path of an example file, or name of an installed example (GetInstalledExamples()); used without port 1. Installed are pieces
   * of scans: "cortex", the folds of a brain; "mane", curls in rows, with a direction; "mountains", ridges and valleys of a
   * landscape. Example files are in safetensors format, as scan_textures.py writes them. Default "".
   */
  void SetExampleFileName(const char* name);
  vtkGetCharFromStdStringMacro(ExampleFileName);
  ///@}

  ///@{
  /**
   * ExampleFileName of the second example, a path or the name of an installed one; used without port 3. Must be set with
   * BlendArrayName. Default "".
   */
  void SetSecondExampleFileName(const char* name);
  vtkGetCharFromStdStringMacro(SecondExampleFileName);
  ///@}

  /**
   * Names of the installed examples.
   */
  vtkStringArray* GetInstalledExamples();

  /**
   * Folder of the installed examples; empty without one.
   */
  const char* GetInstalledExamplesFolder() const;

  ///@{
  /**
   * Seed of the random numbers, any integer. Each seed gives a different sample of the texture. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Size of the texture on the target over its size on the example, both in world units, from 0 to 1e12. 0, the default, for
   * the mean edge length of the target, once subdivided, over that of the plain example: triangles stand for triangles, whatever
   * the units are. Of two examples each has its own scale with 0, and both have this one otherwise, so that the units of both
   * must be the same.
   */
  vtkSetClampMacro(TextureScale, double, 0.0, 1e12);
  vtkGetMacro(TextureScale, double);
  ///@}

  ///@{
  /**
   * Number of times that each triangle of the target is divided into four, -1 to 8. -1, the default, stands for 2 where
   * TextureScale is 0, and else for as many as make edges nearly as long as those of the example at that scale.
   */
  vtkSetClampMacro(Subdivisions, int, -1, 8);
  vtkGetMacro(Subdivisions, int);
  ///@}

  ///@{
  /**
   * Number of scales, 0 to 8: patches of the finest one are 8 mean edges of the example wide, and those of each coarser one
   * twice as wide. 0, the default, for as many as make the widest patches about three features wide; of two examples the
   * larger of both numbers, as far as patches fit on both.
   */
  vtkSetClampMacro(NumberOfScales, int, 0, 8);
  vtkGetMacro(NumberOfScales, int);
  ///@}

  ///@{
  /**
   * Length of the smoothing that takes the texture off the example, world units of the example, at least 0; used without port
   * 2. Waves of this length or shorter are texture: 5 % of them stay in the form, and 94 % of waves ten times as long. Patches
   * within this length of a boundary are left out, because the smooth form draws back there. 0, the default, for a tenth of the
   * root of the area, and for an example file for that of the file; not used for a file that holds the plain example.
   */
  vtkSetClampMacro(SmoothingLength, double, 0.0, 1e300);
  vtkGetMacro(SmoothingLength, double);
  ///@}

  ///@{
  /**
   * SmoothingLength of the second example, world units of that example, at least 0; used without port 4. 0, the default, for a tenth of the root of
   * its area, and for an example file for that of the file.
   */
  vtkSetClampMacro(SecondSmoothingLength, double, 0.0, 1e300);
  vtkGetMacro(SecondSmoothingLength, double);
  ///@}

  ///@{
  /**
   * Name of a point array of the target with one component, from 0 to 1, the share of the second example: features of the
   * first at 0, of the second at 1, and between them islands of both, about as wide as a feature of mean size, that cover
   * such a share of the area. Features are mixed and agree where they meet; their heights are not. Must be set with port 3 or
   * SecondExampleFileName. Default "": one example.
   */
  void SetBlendArrayName(const char* name);
  vtkGetCharFromStdStringMacro(BlendArrayName);
  ///@}

  ///@{
  /**
   * Name of a point array of the target with three components, the direction of the texture: patches are turned so that the
   * direction of ExampleOrientationArrayName comes to lie along it. Parts along normals are left out; where nothing is left,
   * any direction will do. Default "": patches are turned as it happens, for textures that look alike in every direction.
   */
  void SetOrientationArrayName(const char* name);
  vtkGetCharFromStdStringMacro(OrientationArrayName);
  ///@}

  ///@{
  /**
   * Name of a point array of the example with three components, the direction of its texture; a second example on port 3 must
   * have it, too. Must be set with OrientationArrayName for examples on ports; example files hold their direction. Default "".
   */
  void SetExampleOrientationArrayName(const char* name);
  vtkGetCharFromStdStringMacro(ExampleOrientationArrayName);
  ///@}

  ///@{
  /**
   * Name of a point array of the target with one component, from 0.1 to 10, that multiplies the size of the texture from place
   * to place. Sizes should change little over a feature, and triangles must be small enough for the smallest. Default "": one
   * size.
   */
  void SetSizeArrayName(const char* name);
  vtkGetCharFromStdStringMacro(SizeArrayName);
  ///@}

  ///@{
  /**
   * Name of a point array of the target with one component, from 0 to 1, the factor of displacements: full texture at
   * 1, none at 0. Default "": full texture everywhere.
   */
  void SetMaskArrayName(const char* name);
  vtkGetCharFromStdStringMacro(MaskArrayName);
  ///@}

  ///@{
  /**
   * Factor of the displacements, from 0 to 1e6. Printable reduces the result. Default 1.
   */
  vtkSetClampMacro(Strength, double, 0.0, 1e6);
  vtkGetMacro(Strength, double);
  ///@}

  ///@{
  /**
   * Reduces displacements until no triangles of the output intersect, for slicers of 3D printers; needs CGAL. Around
   * triangles that intersect, first the tangential part of the displacements falls, then the part along the normals of the
   * target, by a quarter at a time, which fades over about twice their length. The points in single precision, as STL files
   * hold them, are tested, too. Where triangles of the target itself intersect they remain, with a warning:
   * GetNumberOfSelfIntersections(). Default off.
   */
  vtkSetMacro(Printable, bool);
  vtkGetMacro(Printable, bool);
  vtkBooleanMacro(Printable, bool);
  ///@}

  ///@{
  /**
   * Name of the point array with the displacement of each point; not empty. Default "Displacement".
   */
  void SetDisplacementArrayName(const char* name);
  vtkGetCharFromStdStringMacro(DisplacementArrayName);
  ///@}

  /**
   * TextureScale of the last update, for the first example; of the last block of a composite input. 0 before the first.
   */
  double GetTextureScaleUsed() const;

  /**
   * Number of subdivisions of the last update; of the last block of a composite input. 0 before the first.
   */
  int GetSubdivisionsUsed() const;

  /**
   * Number of scales of the last update; 0 before the first.
   */
  int GetNumberOfScalesUsed() const;

  /**
   * Root of the mean square distance of the patches of the last update from the nearest ones of the example, at the finest
   * scale, over the root of the mean square displacement of the example: 0 where each piece is one of the example. The
   * largest one of both examples and of all blocks.
   */
  double GetMismatch() const;

  /**
   * Number of pairs of triangles that still intersect in the last update with Printable, where those of the target do; -1
   * after one without. In all blocks.
   */
  vtkTypeInt64 GetNumberOfSelfIntersections() const;

  /**
   * Share of the height of the texture that Printable has kept in the last update, 0 to 1: the integral of the absolute
   * displacement along the normals of the target, over the same before; 1 without Printable. In all blocks.
   */
  double GetHeightKept() const;

  /**
   * Number of textures synthesized since this object was made. Unchanged while only Strength, Printable,
   * MaskArrayName or DisplacementArrayName change.
   */
  vtkTypeInt64 GetNumberOfSyntheses() const;

protected:
  vtkGeometricTextureFromExample();
  ~vtkGeometricTextureFromExample() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkGeometricTextureFromExample(const vtkGeometricTextureFromExample&) = delete;
  void operator=(const vtkGeometricTextureFromExample&) = delete;

  std::string ExampleFileName;
  std::string SecondExampleFileName;
  int Seed = 0;
  double TextureScale = 0.0;
  int Subdivisions = -1;
  int NumberOfScales = 0;
  double SmoothingLength = 0.0;
  double SecondSmoothingLength = 0.0;
  std::string BlendArrayName;
  std::string OrientationArrayName;
  std::string ExampleOrientationArrayName;
  std::string SizeArrayName;
  std::string MaskArrayName;
  double Strength = 1.0;
  bool Printable = false;
  std::string DisplacementArrayName = "Displacement";

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
