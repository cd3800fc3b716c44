// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkElasticRestFilter
 * @brief   Generates rest states of a soft body: shapes that it lies in after random drops on a floor, or next to given ones
 *
 * Drops an elastic body on a floor, with a random orientation and spin, and returns the shape in which it comes to rest
 * (appendix C.2 of [Kuai2026]): training data for flow matching, or soft tissue under its weight. Or lays it down in given
 * shapes, such as samples of a model, and returns the rest state next to each. The body is of linear
 * tetrahedra with a stable neo-Hookean material [Smith2018]; time steps are implicit Euler by projected Newton with a
 * line search, contact with the floor is a logarithmic barrier with lagged friction [Li2020].
 *
 * @par Input
 * Port 0: a closed vtkPolyData with triangles, polygons or strips; or a vtkUnstructuredGrid of tetrahedra; float or double
 * points; or a composite dataset of such blocks, each of which is dropped by itself. A surface is remeshed to
 * NumberOfSurfacePoints points and filled with tetrahedra by TetGen, which move its own points along; it must be manifold
 * with consistent winding and without self-intersections, and vtkSurfaceRepairFilter makes it so. Empty input gives empty
 * output.
 *
 * Port 1, optional: a vtkUnstructuredGrid of tetrahedra around the same surface, such as vtkTetrahedralizeFilter makes of
 * a decimated one: it is simulated in place of those made here. Not used for an input of tetrahedra. Needed where the
 * library was built without CGAL or TetGen.
 *
 * Port 2, optional: shapes, a moved copy of the dataset of port 0, or a composite dataset of such copies, as
 * vtkFlowMatchingDeformer makes them; of about the size of the body, and of any height above the floor. Then nothing falls:
 * for each shape the body is laid, undeformed, next to it, drawn into it by springs, which end where the floor or the body
 * itself is in the way, and let go; it creeps to the next equilibrium, and is turned as the input lies unless Align is off.
 * Seed, NumberOfSamples, DropHeight, the spins, RandomOrientation, Damping and MaximumTime are not used, and TimeStep is where
 * the creep begins. For a composite dataset on port 0, a composite dataset with the shapes of each block in its place, as
 * vtkFlowMatchingDeformer makes it of the same input.
 *
 * @par Output
 * A vtkMultiBlockDataSet (for a composite input, the input's class with one in place of each block) with a copy of the
 * input for each sample, named "Sample k" for k = FirstSample, FirstSample + 1, ...: with moved points of the same
 * precision, without normals, with a point array of the displacement (three components) and the field arrays
 * "SettlingTime" (seconds of the fall, without those of the creep; 0 for shapes), "ForceImbalance" (norm of the forces that are left
 * on the nodes over the weight), "SmallestVolumeRatio" (of a tetrahedron, over that before), "EnergyRise" (largest rise
 * of the energy in a time step over weight times diagonal) and "FloorHeight" (along UpDirection, world units). The floor
 * is at the lowest point of the input.
 *
 * @par Units
 * Properties are in SI units. LengthUnit says how long a world unit is; by default the diagonal of the box of the
 * body is half a meter, so that results do not depend on the unit of the file. How far a body sinks depends on density
 * times gravity times its size, over YoungsModulus.
 *
 * @par What is promised
 * In a rest state forces are in balance to half a thousandth of the weight, no tetrahedron is turned over, no node of the
 * simulated mesh is below the floor, and the energy has never risen by more than its rounding. Points of the body do not
 * pass through its own triangles; edges may pass each other, and there is no friction of the body with itself. The points
 * of a surface that is finer than the simulated mesh follow it; those that would pass the floor are put onto it. A body
 * that has not come to rest after MaximumTime creeps to the next equilibrium. Time steps end after eight iterations, which
 * slows the turns of stiff bodies (above about 1e8 Pa), so that they come to rest later than they should.
 *
 * @par Cost
 * About two seconds of one processor for each sample on 600 nodes, and a third of a second for a shape; samples are made in
 * parallel. Tetrahedra are kept until
 * the input or a property of them changes. The same seed gives the same bits for every number of threads, and sample k is
 * the same alone or in a batch. Another kind of processor may give another rest state: a fall depends on its last bits.
 *
 * @sa vtkTetrahedralizeFilter, vtkPoseEnsembleFilter, vtkFlowMatchingTrainer, vtkFlowMatchingDeformer
 */

#ifndef vtkElasticRestFilter_h
#define vtkElasticRestFilter_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisEnsemblesModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class VTKSURFACESYNTHESISENSEMBLES_EXPORT vtkElasticRestFilter : public vtkDataObjectAlgorithm
{
public:
  static vtkElasticRestFilter* New();
  vtkTypeMacro(vtkElasticRestFilter, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Sets the tetrahedra of port 1, as a connection or as data; null (the default) for none.
   */
  void SetTetrahedraConnection(vtkAlgorithmOutput* port);
  void SetTetrahedraData(vtkDataObject* tetrahedra);
  ///@}

  /**
   * Removes the tetrahedra. ParaView needs this method, because its clean command cannot name a port.
   */
  void RemoveTetrahedra() { this->SetInputConnection(1, nullptr); }

  ///@{
  /**
   * Sets the shapes of port 2, as a connection or as data; null (the default) for none.
   */
  void SetShapesConnection(vtkAlgorithmOutput* port);
  void SetShapesData(vtkDataObject* shapes);
  ///@}

  /**
   * Removes the shapes. ParaView needs this method, because its clean command cannot name a port.
   */
  void RemoveShapes() { this->SetInputConnection(2, nullptr); }

  ///@{
  /**
   * Seed of the random numbers, any integer. Each seed gives other orientations and spins. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Number of samples, each a dataset of its own; at least 1. Default 6.
   */
  vtkSetClampMacro(NumberOfSamples, int, 1, VTK_INT_MAX);
  vtkGetMacro(NumberOfSamples, int);
  ///@}

  ///@{
  /**
   * Index of the first sample, at least 0; an ensemble can be generated in parts. Default 0.
   */
  vtkSetClampMacro(FirstSample, int, 0, VTK_INT_MAX);
  vtkGetMacro(FirstSample, int);
  ///@}

  ///@{
  /**
   * Memory limit of the output, MiB, at least 0; 0, the default, for three quarters of the memory of the machine. More
   * samples than fit are an error before the work begins; the message names a number that fits.
   */
  vtkSetClampMacro(MemoryLimit, int, 0, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

  ///@{
  /**
   * Distance of neighboring samples in a grid in the xy plane, as a fraction of the box of the input along each axis; at least
   * 0. 0 leaves all samples in the place of the input. The array of displacements is without it, and each sample gets the
   * field array "Translation", three components, world units. Default 0.
   */
  vtkSetClampMacro(Spread, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Spread, double);
  ///@}

  ///@{
  /**
   * Number of points to which a surface is remeshed before it is filled with tetrahedra, at least 0; 0 fills the surface
   * as it is. Up to half as many again where the two sides of a thin part would meet. Not used with tetrahedra. Default 500.
   */
  vtkSetClampMacro(NumberOfSurfacePoints, int, 0, VTK_INT_MAX);
  vtkGetMacro(NumberOfSurfacePoints, int);
  ///@}

  ///@{
  /**
   * Length of a world unit in meters: 0.001 for millimeters. 0, the default, for the one with which the diagonal of the
   * box of the body is half a meter.
   */
  vtkSetClampMacro(LengthUnit, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(LengthUnit, double);
  ///@}

  ///@{
  /**
   * Young's modulus, pascals, larger than 0. Default 10000, that of soft tissue.
   */
  vtkSetClampMacro(YoungsModulus, double, 1e-3, 1e15);
  vtkGetMacro(YoungsModulus, double);
  ///@}

  ///@{
  /**
   * Poisson's ratio, from 0 to 0.495. Default 0.4.
   */
  vtkSetClampMacro(PoissonsRatio, double, 0.0, 0.495);
  vtkGetMacro(PoissonsRatio, double);
  ///@}

  ///@{
  /**
   * Density, kilograms per cubic meter, larger than 0. Default 1000.
   */
  vtkSetClampMacro(Density, double, 1e-6, 1e9);
  vtkGetMacro(Density, double);
  ///@}

  ///@{
  /**
   * Coefficient of Coulomb's friction on the floor, at least 0. Default 0.5.
   */
  vtkSetClampMacro(Friction, double, 0.0, 100.0);
  vtkGetMacro(Friction, double);
  ///@}

  ///@{
  /**
   * Acceleration of gravity, meters per square second, larger than 0. Default 9.81.
   */
  vtkSetClampMacro(Gravity, double, 1e-3, 1e6);
  vtkGetMacro(Gravity, double);
  ///@}

  ///@{
  /**
   * Loss of momentum by the air, per second, at least 0; without it a ball rolls on and on. Default 0.5.
   */
  vtkSetClampMacro(Damping, double, 0.0, 1e6);
  vtkGetMacro(Damping, double);
  ///@}

  ///@{
  /**
   * Height of the lowest point above the floor at the beginning, meters, at least 0. Default 0.1.
   */
  vtkSetClampMacro(DropHeight, double, 0.0, 1e6);
  vtkGetMacro(DropHeight, double);
  ///@}

  ///@{
  /**
   * Least angular speed at the beginning, radians per second, at least 0. The speed is uniform between it and MaximumSpin,
   * about a random axis. Default 3.14159265358979.
   */
  vtkSetClampMacro(MinimumSpin, double, 0.0, 1e4);
  vtkGetMacro(MinimumSpin, double);
  ///@}

  ///@{
  /**
   * Largest angular speed at the beginning, radians per second, at least 0; below MinimumSpin it is an error. Default
   * 9.42477796076938.
   */
  vtkSetClampMacro(MaximumSpin, double, 0.0, 1e4);
  vtkGetMacro(MaximumSpin, double);
  ///@}

  ///@{
  /**
   * On: any orientation at the beginning is as likely as any other. Off: that of the input. Default on.
   */
  vtkSetMacro(RandomOrientation, bool);
  vtkGetMacro(RandomOrientation, bool);
  vtkBooleanMacro(RandomOrientation, bool);
  ///@}

  ///@{
  /**
   * On: rest states are turned about UpDirection, so that the longest axis of their plan is that of the input's, and are
   * centered on it; of the two turns that do so by the one that brings the body nearer to the input, or, of shapes, by the
   * smaller one. Off: they lie as they have come to rest. Default on.
   */
  vtkSetMacro(Align, bool);
  vtkGetMacro(Align, bool);
  vtkBooleanMacro(Align, bool);
  ///@}

  ///@{
  /**
   * On: points of the body do not pass through its own triangles; edges may pass each other, and there is no friction of
   * the body with itself. Off: parts of the body may lie in each other. Default on.
   */
  vtkSetMacro(SelfContact, bool);
  vtkGetMacro(SelfContact, bool);
  vtkBooleanMacro(SelfContact, bool);
  ///@}

  ///@{
  /**
   * Direction upwards, against gravity; any length but 0. Default (0, 0, 1).
   */
  vtkSetVector3Macro(UpDirection, double);
  vtkGetVector3Macro(UpDirection, double);
  ///@}

  ///@{
  /**
   * Largest time step, seconds, from 0.0001 to 1; longer ones lose more of the motion. Default 0.04.
   */
  vtkSetClampMacro(TimeStep, double, 1e-4, 1.0);
  vtkGetMacro(TimeStep, double);
  ///@}

  ///@{
  /**
   * Simulated time after which a body that still moves creeps to its equilibrium, seconds, at least 0. 0 lets it creep
   * from the beginning. Default 10.
   */
  vtkSetClampMacro(MaximumTime, double, 0.0, 1e6);
  vtkGetMacro(MaximumTime, double);
  ///@}

  ///@{
  /**
   * Name of the point array with the displacement from the input; not empty. Default "Displacement".
   */
  void SetDisplacementArrayName(const char* name);
  vtkGetCharFromStdStringMacro(DisplacementArrayName);
  ///@}

  /**
   * Number of bodies prepared since this object was made: surfaces filled with tetrahedra, or tetrahedra read. Unchanged
   * while only the seed and the samples change.
   */
  vtkTypeInt64 GetNumberOfPreparations() const;

protected:
  vtkElasticRestFilter();
  ~vtkElasticRestFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkElasticRestFilter(const vtkElasticRestFilter&) = delete;
  void operator=(const vtkElasticRestFilter&) = delete;

  int Seed = 0;
  int NumberOfSamples = 6;
  int FirstSample = 0;
  int MemoryLimit = 0;
  double Spread = 0.0;
  int NumberOfSurfacePoints = 500;
  double LengthUnit = 0.0;
  double YoungsModulus = 1e4;
  double PoissonsRatio = 0.4;
  double Density = 1e3;
  double Friction = 0.5;
  double Gravity = 9.81;
  double Damping = 0.5;
  double DropHeight = 0.1;
  double MinimumSpin = 3.14159265358979;
  double MaximumSpin = 9.42477796076938;
  bool RandomOrientation = true;
  bool Align = true;
  bool SelfContact = true;
  double UpDirection[3] = { 0.0, 0.0, 1.0 };
  double TimeStep = 0.04;
  double MaximumTime = 10.0;
  std::string DisplacementArrayName = "Displacement";

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
