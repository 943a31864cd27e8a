/**
 * @class   vtkTetFusion
 * @brief   simplifies tetrahedral meshes with all their arrays
 *
 * vtkTetFusion makes a mesh of fewer tetrahedra from a vtkUnstructuredGrid. By default the boundary
 * stays as it is, nothing is inverted, and every point and cell array comes out under its name and
 * type. The result is that of the command `tetfusion simplify` with the same options, bit for bit,
 * for any number of threads.
 *
 * Which arrays steer is set with SetInputArrayToProcess() (indices 0, 1, ...) or
 * AddSteeringArray(); without either it is the active scalars of the points, else the first
 * floating-point point array, of these the first that is not the same everywhere. With no goal
 * (TargetReduction, NumberOfTetsOutput) and no limit the mesh is simplified as far as it goes with
 * no steering field off by more than 1 % of its range at any point of the input.
 *
 * Cells of lower dimension are kept, with their points, unless DropPatches leaves them out. Ghost
 * cells are not part of the output, and their points stay where they are. Of a composite input each
 * block is simplified for itself, so that blocks which touch fit afterwards only with a boundary
 * that stays; a block without cells that have a volume (a patch, a side set, none) comes back as it
 * is, as an unstructured grid. An abort ends all blocks that are not done.
 *
 * While it runs, progress events come at least ten times a second, on the thread that called
 * Update(), and the progress never falls; an observer may call SetAbortExecute(1). The output is
 * empty then, the error code vtkErrorCode::UserError + 130. What fails is an error event and
 * vtkErrorCode::UserError plus the exit code of the command: 2 usage, 3 bad input, 4 reading or
 * writing, 5 memory, 6 a goal that was not reached, with Strict.
 */
#ifndef vtkTetFusion_h
#define vtkTetFusion_h

#include <vtkTetFusionFilterModule.h>
#include <vtkUnstructuredGridAlgorithm.h>

#include <memory>
#include <string>

class vtkDataObjectTree;

class VTKTETFUSIONFILTER_EXPORT vtkTetFusion : public vtkUnstructuredGridAlgorithm {
 public:
  static vtkTetFusion* New();
  vtkTypeMacro(vtkTetFusion, vtkUnstructuredGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The goal: the share of the tetrahedra that is to go, in [0, 1), as in 0.9. 0, the default:
   * none.
   */
  vtkSetMacro(TargetReduction, double);
  vtkGetMacro(TargetReduction, double);
  ///@}

  ///@{
  /**
   * The goal as the number of tetrahedra that are to be left. 0, the default: none.
   */
  vtkSetMacro(NumberOfTetsOutput, vtkIdType);
  vtkGetMacro(NumberOfTetsOutput, vtkIdType);
  ///@}

  ///@{
  /**
   * At no point of the input is a steering field off by more than this share of its range, in
   * (0, 1], as in 0.01. 0, the default: anything with a goal, MaximumRMS or a tolerance
   * of a steering array, else 0.01.
   */
  vtkSetMacro(MaximumError, double);
  vtkGetMacro(MaximumError, double);
  ///@}

  ///@{
  /**
   * No fusion may change a steering field by more in the mean of squares, as a share of its range,
   * in (0, 1]; an estimate. 0, the default: anything.
   */
  vtkSetMacro(MaximumRMS, double);
  vtkGetMacro(MaximumRMS, double);
  ///@}

  ///@{
  /**
   * Is a goal that cannot be reached an error, and not only a warning? The output has the best mesh
   * in any case. Default: no.
   */
  vtkSetMacro(Strict, bool);
  vtkGetMacro(Strict, bool);
  vtkBooleanMacro(Strict, bool);
  ///@}

  enum Methods { FUSE = 0, TETFUSE = 1 };
  ///@{
  /**
   * FUSE, the default: neighbouring vertices become one, the cheapest first. TETFUSE: the operation
   * of the paper, the four vertices of a tetrahedron become one.
   */
  vtkSetClampMacro(Method, int, FUSE, TETFUSE);
  vtkGetMacro(Method, int);
  void SetMethodToFuse() { this->SetMethod(FUSE); }
  void SetMethodToTetFuse() { this->SetMethod(TETFUSE); }
  ///@}

  enum BoundaryModes { EXACT = 0, PLANAR = 1, WITHIN = 2 };
  ///@{
  /**
   * What may become of the boundary surface, and of surfaces between regions. EXACT, the default:
   * every triangle stays. PLANAR: flat parts and straight edges get new triangles. WITHIN: it may
   * move by BoundaryTolerance.
   */
  vtkSetClampMacro(BoundaryMode, int, EXACT, WITHIN);
  vtkGetMacro(BoundaryMode, int);
  void SetBoundaryModeToExact() { this->SetBoundaryMode(EXACT); }
  void SetBoundaryModeToPlanar() { this->SetBoundaryMode(PLANAR); }
  void SetBoundaryModeToWithin() { this->SetBoundaryMode(WITHIN); }
  ///@}

  ///@{
  /**
   * With BoundaryMode WITHIN: a share of the diagonal of the bounding box, in (0, 1). Default:
   * 0.001.
   */
  vtkSetMacro(BoundaryTolerance, double);
  vtkGetMacro(BoundaryTolerance, double);
  ///@}

  ///@{
  /**
   * With BoundaryMode PLANAR and WITHIN: where two triangles of a surface meet whose normals are so
   * many degrees apart, or more, the edge is sharp, and stays; in (0, 180], of which the last is
   * none. Default: 40.
   */
  vtkSetMacro(FeatureAngle, double);
  vtkGetMacro(FeatureAngle, double);
  ///@}

  ///@{
  /**
   * With Method FUSE: no new tetrahedron has a lower mean ratio (1 is regular, 0 flat), or, where
   * the input has one below it, one that is lower than that by more than a twentieth; in [0, 1).
   * Default: 0.22; with TETFUSE another value is an error.
   */
  vtkSetMacro(MinimumQuality, double);
  vtkGetMacro(MinimumQuality, double);
  ///@}

  ///@{
  /**
   * With Method FUSE and a boundary that stays: the integrals of all floating-point arrays stay,
   * but for arrays that say regions, whose values cells keep. Default: no.
   */
  vtkSetMacro(Conserve, bool);
  vtkGetMacro(Conserve, bool);
  vtkBooleanMacro(Conserve, bool);
  ///@}

  ///@{
  /**
   * In a single fusion the values of the fused may differ by this share of a field's range. 0: the
   * default of the method, which is off with FUSE and 0.025 with TETFUSE. Infinity is off.
   */
  vtkSetMacro(ScalarTolerance, double);
  vtkGetMacro(ScalarTolerance, double);
  ///@}

  ///@{
  /**
   * A tetrahedron's height may grow by this factor in a round, at least 1. 0: the default of the
   * method, which is off with FUSE and 5 with TETFUSE. Infinity is off.
   */
  vtkSetMacro(StretchFactor, double);
  vtkGetMacro(StretchFactor, double);
  ///@}

  ///@{
  /**
   * Longest over shortest edge may not exceed this, at least 1, unless it was worse. 0, the
   * default: off.
   */
  vtkSetMacro(AspectRatio, double);
  vtkGetMacro(AspectRatio, double);
  ///@}

  ///@{
  /**
   * No tetrahedron grows beyond this volume; larger ones do not grow. 0, the default: off.
   */
  vtkSetMacro(MaximumVolume, double);
  vtkGetMacro(MaximumVolume, double);
  ///@}

  ///@{
  /**
   * With Method TETFUSE: no tetrahedron that touches the boundary is fused. Default: no.
   */
  vtkSetMacro(BoundaryTetsStay, bool);
  vtkGetMacro(BoundaryTetsStay, bool);
  vtkBooleanMacro(BoundaryTetsStay, bool);
  ///@}

  ///@{
  /**
   * An array that steers, beside those of SetInputArrayToProcess(). `association` is
   * vtkDataObject::FIELD_ASSOCIATION_POINTS or _CELLS. A tolerance above 0, a share of the array's
   * range of 1 at most, takes the place of MaximumError (with TETFUSE of ScalarTolerance) for this
   * array.
   */
  void AddSteeringArray(int association, const char* name, double tolerance = 0);
  void RemoveAllSteeringArrays();
  int GetNumberOfSteeringArrays();
  ///@}

  ///@{
  /**
   * The same for the arrays of one association, as lists of names are set (in ParaView).
   */
  void AddSteeringPointArray(const char* name);
  void AddSteeringCellArray(const char* name);
  void RemoveAllSteeringPointArrays();
  void RemoveAllSteeringCellArrays();
  ///@}

  ///@{
  /**
   * Are the interfaces between regions kept, as BoundaryMode says? Regions are told apart by the
   * cell arrays of one component that were added; where none was, by those of integers named like
   * material, region, physical, tissue, block, zone, part, label, and ObjectId, medit:ref and
   * tetgen:ref. Default: yes.
   */
  vtkSetMacro(KeepRegions, bool);
  vtkGetMacro(KeepRegions, bool);
  vtkBooleanMacro(KeepRegions, bool);
  void AddRegionArray(const char* name);
  void RemoveAllRegionArrays();
  int GetNumberOfRegionArrays();
  ///@}

  ///@{
  /**
   * Where the mesh stays as it is: "box=X0,X1,Y0,Y1,Z0,Z1" in VTK's order of bounds,
   * "sphere=X,Y,Z,RADIUS", or a point array and a value, as in "pressure>0.5" (of a vector its
   * length). A tetrahedron stays if all of its points are in one of those that were added.
   */
  void AddRegionOfInterest(const char* region);
  void RemoveAllRegionsOfInterest();
  int GetNumberOfRegionsOfInterest();
  ///@}

  ///@{
  /**
   * A point array of finite numbers of 0 or more, or "cell:NAME" for a cell array, with the method
   * fuse: errors count so many times as much there, so that the mesh stays finer. None, the
   * default: all count alike.
   */
  vtkSetStringMacro(WeightArrayName);
  vtkGetStringMacro(WeightArrayName);
  ///@}

  ///@{
  /**
   * Has the output the point array OriginalPointIds: the number that a point which stayed has in
   * the input, -1 of one that is new? Where cells are split or straightened, points that no cell
   * uses are not counted; of a mesh in parts each counts its own. Default: no.
   */
  vtkSetMacro(OriginalIds, bool);
  vtkGetMacro(OriginalIds, bool);
  vtkBooleanMacro(OriginalIds, bool);
  ///@}

  ///@{
  /**
   * Split hexahedra, voxels, wedges and pyramids into tetrahedra? Else such cells are an error, the
   * default.
   */
  vtkSetMacro(Tetrahedralize, bool);
  vtkGetMacro(Tetrahedralize, bool);
  vtkBooleanMacro(Tetrahedralize, bool);
  ///@}

  ///@{
  /**
   * Take cells of higher order, as ten-node tetrahedra, as straight ones, by their corners? Else
   * such cells are an error, the default.
   */
  vtkSetMacro(Linearize, bool);
  vtkGetMacro(Linearize, bool);
  vtkBooleanMacro(Linearize, bool);
  ///@}

  ///@{
  /**
   * Leave out cells without volume, of any type, which else hold their points where they are? A
   * block of a composite input that has no others comes out empty. Default: no.
   */
  vtkSetMacro(DropPatches, bool);
  vtkGetMacro(DropPatches, bool);
  vtkBooleanMacro(DropPatches, bool);
  ///@}

  ///@{
  /**
   * Leave out some of these cells alone, so that the boundary may move there: those with a value of
   * a cell array of numbers, as in "patch=3", which each block must have.
   */
  void AddDroppedPatch(const char* patch);
  void RemoveAllDroppedPatches();
  int GetNumberOfDroppedPatches();
  ///@}

  ///@{
  /**
   * Threads to use; 0, the default, is what OMP_NUM_THREADS says, or one for each processor that
   * the program may use. The result does not depend on it.
   */
  vtkSetClampMacro(NumberOfThreads, int, 0, VTK_INT_MAX);
  vtkGetMacro(NumberOfThreads, int);
  ///@}

  ///@{
  /**
   * Bytes that a run may take beside its input and output. 0, the default: half of what the machine
   * allows, divided by the runs that go on at once in the process. The result does not depend on
   * it.
   */
  vtkSetMacro(MemoryLimit, vtkTypeInt64);
  vtkGetMacro(MemoryLimit, vtkTypeInt64);
  ///@}

  ///@{
  /**
   * A folder that is there, for what does not fit into the memory. Without one, the default, that
   * is an error.
   */
  vtkSetStringMacro(ScratchDirectory);
  vtkGetStringMacro(ScratchDirectory);
  ///@}

  ///@{
  /**
   * Tetrahedra in each of the chunks that threads work on. The result depends on it. Default:
   * 200000.
   */
  vtkSetMacro(ChunkTets, vtkIdType);
  vtkGetMacro(ChunkTets, vtkIdType);
  ///@}

  ///@{
  /**
   * Of the last run (of a composite input: of its last block): which limit ended it, as a sentence;
   * everything as JSON, as the command's --report. Of all blocks: what was locked or left out, a
   * line each. Empty where there was none.
   */
  const char* GetStopSentence();
  const char* GetReport();
  const char* GetNotices();
  ///@}

  ///@{
  /**
   * Of the last run, whether VTK shows errors and warnings or not: what failed first (empty where
   * nothing did, and after an abort; GetErrorCode() has the code), and the warnings, a line each.
   * What is about a block of a composite input begins with the block's name, or its flat index.
   */
  const char* GetErrorMessage();
  const char* GetWarnings();
  ///@}

  /**
   * Was there a goal (TargetReduction, NumberOfTetsOutput), and has the last run reached it? Of a
   * composite input: in all blocks.
   */
  bool GetGoalReached();

  vtkTypeBool ProcessRequest(vtkInformation* request, vtkInformationVector** inputVector,
                             vtkInformationVector* outputVector) override;

 protected:
  vtkTetFusion();
  ~vtkTetFusion() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(vtkInformation* request, vtkInformationVector** inputVector,
                        vtkInformationVector* outputVector);
  int RequestData(vtkInformation* request, vtkInformationVector** inputVector,
                  vtkInformationVector* outputVector) override;

  double TargetReduction = 0;
  vtkIdType NumberOfTetsOutput = 0;
  double MaximumError = 0;
  double MaximumRMS = 0;
  bool Strict = false;
  int Method = FUSE;
  int BoundaryMode = EXACT;
  double BoundaryTolerance = 0.001;
  double FeatureAngle = 40;
  double MinimumQuality = 0.22;
  bool Conserve = false;
  double ScalarTolerance = 0;
  double StretchFactor = 0;
  double AspectRatio = 0;
  double MaximumVolume = 0;
  bool BoundaryTetsStay = false;
  bool KeepRegions = true;
  bool OriginalIds = false;
  bool Tetrahedralize = false;
  bool Linearize = false;
  bool DropPatches = false;
  int NumberOfThreads = 0;
  vtkTypeInt64 MemoryLimit = 0;
  char* WeightArrayName = nullptr;
  char* ScratchDirectory = nullptr;
  vtkIdType ChunkTets = 200000;

 private:
  vtkTetFusion(const vtkTetFusion&) = delete;
  void operator=(const vtkTetFusion&) = delete;

  void SimplifyBlocks(vtkDataObjectTree* input, vtkDataObjectTree* output);
  void SimplifyBlock(vtkDataObject* block, vtkUnstructuredGrid* output);
  void SimplifyGrid(vtkDataObject* input, vtkUnstructuredGrid* output);
  void Fail(int code, const std::string& message);
  void Warn(const std::string& message);

  struct Internals;
  std::unique_ptr<Internals> Internal;
};

#endif
