#include <vtkTetFusion.h>

#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataArray.h>
#include <vtkDataObjectTree.h>
#include <vtkDemandDrivenPipeline.h>
#include <vtkErrorCode.h>
#include <vtkGenericCell.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tetfusion.h"
#include "vtk/filter/grid_result.h"
#include "vtk/filter/grid_view.h"
#include "vtk/versions/vtk_versions.h"

vtkStandardNewMacro(vtkTetFusion);

namespace {

// Flags of vtkGhostType for cells that are no part of the mesh, as tetfusion::Mesh::ghosts says.
constexpr unsigned char kNotOurs = vtkDataSetAttributes::DUPLICATECELL |
                                   vtkDataSetAttributes::REFINEDCELL |
                                   vtkDataSetAttributes::HIDDENCELL;

constexpr double kUsualQuality = 0.22;  // the default of MinimumQuality

bool has_own_cells(vtkUnstructuredGrid* grid) {
  const std::vector<std::uint8_t> ghosts = ghost_flags(grid);
  if (ghosts.empty()) return grid->GetNumberOfCells() > 0;
  return std::ranges::any_of(ghosts, [](std::uint8_t flag) { return (flag & kNotOurs) == 0; });
}

bool has_volume(vtkDataSet* block) {
  vtkNew<vtkGenericCell> cell;
  for (vtkIdType c = 0; c < block->GetNumberOfCells(); ++c) {
    if (block->GetCellType(c) != cell->GetCellType()) cell->SetCellType(block->GetCellType(c));
    if (cell->GetCellDimension() == 3) return true;
  }
  return false;
}

// Straight or curved: all but tetrahedra, triangles and what has less dimensions.
bool is_split(vtkGenericCell* cell) {
  if (cell->GetCellDimension() == 3) return cell->GetNumberOfFaces() != 4;
  return cell->GetCellDimension() == 2 && cell->GetNumberOfEdges() != 3;
}

bool has_cells_to_split(vtkUnstructuredGrid* grid, bool without_patches) {
  vtkNew<vtkGenericCell> cell;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    if (grid->GetCellType(c) == cell->GetCellType()) continue;  // looked at
    cell->SetCellType(grid->GetCellType(c));
    if (is_split(cell) && (cell->GetCellDimension() == 3 || !without_patches)) return true;
  }
  return false;
}

// The parts of a cell that is split have its number.
void unmark_global_ids(vtkDataSetAttributes* cells) {
  vtkDataArray* const ids = cells->GetGlobalIds();
  if (ids == nullptr) return;
  cells->SetActiveAttribute(-1, vtkDataSetAttributes::GLOBALIDS);
  if (cells->GetPedigreeIds() != nullptr) return;
  cells->SetActiveAttribute(ids->GetName(), vtkDataSetAttributes::PEDIGREEIDS);
}

// Zero stands for what was not given.
template <class T>
std::optional<T> if_given(T value) {
  return value != 0 ? std::optional<T>(value) : std::nullopt;
}

tetfusion::BoundaryMode boundary_mode(int mode) {
  if (mode == vtkTetFusion::WITHIN) return tetfusion::BoundaryMode::kWithin;
  return mode == vtkTetFusion::PLANAR ? tetfusion::BoundaryMode::kPlanar
                                      : tetfusion::BoundaryMode::kExact;
}

const char* name_of_method(int method) { return method == vtkTetFusion::FUSE ? "fuse" : "tetfuse"; }

const char* name_of_mode(int mode) {
  if (mode == vtkTetFusion::WITHIN) return "within";
  return mode == vtkTetFusion::PLANAR ? "planar" : "exact";
}

// "block 'inlet': ", or its flat index where it has no name, before what is said about it.
std::string words_for_block(vtkCompositeDataIterator* blocks) {
  const char* name = blocks->HasCurrentMetaData() != 0
                         ? blocks->GetCurrentMetaData()->Get(vtkCompositeDataSet::NAME())
                         : nullptr;
  if (name != nullptr && *name != '\0') return "block '" + std::string(name) + "': ";
  return "block " + std::to_string(blocks->GetCurrentFlatIndex()) + ": ";
}

// Progress events of a filter: as the library reports, and in between, so that an observer can ask
// for an abort at any time.
class Heartbeat {
 public:
  explicit Heartbeat(vtkTetFusion* filter) : filter_(filter) {}

  void report(double share, std::string_view phase) {
    share_ = share;
    phase_ = phase;
    filter_->SetProgressText(phase_.c_str());
    beat();
  }
  bool wants_abort() {
    if (std::chrono::steady_clock::now() - last_ > kPause) beat();
    return tetfusion::vtk_version::is_aborted(filter_);
  }

 private:
  static constexpr std::chrono::milliseconds kPause{60};

  void beat() {
    last_ = std::chrono::steady_clock::now();
    filter_->UpdateProgress(share_);
  }

  vtkTetFusion* filter_;
  double share_ = 0;
  std::string phase_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace

struct vtkTetFusion::Internals {
  struct Steering {
    int association;
    std::string name;
    double tolerance;
  };
  std::vector<Steering> steering;
  std::vector<std::string> regions;
  std::vector<std::string> roi;
  std::vector<std::string> dropped_patches;

  // Of the last update, and of the block in work.
  struct Update {
    std::string stop_sentence, report, notices, warnings, error_message;
    std::string block;
    int blocks_without_volume = 0, empty_blocks = 0, other_blocks = 0;
    int goals = 0, goals_reached = 0;  // of grids
    bool has_failed = false;
  };
  Update update;

  std::string add_inputs_to_process(vtkTetFusion* filter, vtkUnstructuredGrid* input,
                                    const GridView& view, tetfusion::Options* options) const;
  tetfusion::Options options(vtkTetFusion* filter) const;
  void remove_steering(int association) {
    std::erase_if(steering, [&](const Steering& s) { return s.association == association; });
  }
};

// Those of SetInputArrayToProcess(). Returns what is wrong with them, if anything.
std::string vtkTetFusion::Internals::add_inputs_to_process(vtkTetFusion* filter,
                                                           vtkUnstructuredGrid* input,
                                                           const GridView& view,
                                                           tetfusion::Options* options) const {
  vtkInformationVector* wanted = filter->GetInformation()->Get(INPUT_ARRAYS_TO_PROCESS());
  const int count = wanted != nullptr ? wanted->GetNumberOfInformationObjects() : 0;
  for (int i = 0; i < count; ++i) {
    int association = 0;
    vtkDataArray* array = filter->GetInputArrayToProcess(i, input, association);
    const std::string name = array != nullptr ? view.name_of(array) : "";
    if (name.empty()) {
      vtkInformation* const which = wanted->GetInformationObject(i);
      const char* const given = which->Get(vtkDataObject::FIELD_NAME());
      return "the input has no numbers" +
             (given != nullptr ? " by the name '" + std::string(given) + "'" : std::string()) +
             " for input array to process " + std::to_string(i);
    }
    options->arrays.push_back({name, association == vtkDataObject::FIELD_ASSOCIATION_CELLS, {}});
  }
  return "";
}

tetfusion::Options vtkTetFusion::Internals::options(vtkTetFusion* filter) const {
  const bool fuse = filter->Method == FUSE;
  tetfusion::Options o;
  o.reduction = if_given(filter->TargetReduction);
  if (filter->NumberOfTetsOutput != 0) {
    o.tets = static_cast<std::uint64_t>(std::max<vtkIdType>(filter->NumberOfTetsOutput, 0));
  }
  o.max_error = if_given(filter->MaximumError);
  o.max_rms = if_given(filter->MaximumRMS);
  o.strict = filter->Strict;
  o.method = fuse ? tetfusion::Operation::kFuse : tetfusion::Operation::kTetFuse;
  o.boundary = boundary_mode(filter->BoundaryMode);
  o.boundary_distance = filter->BoundaryTolerance;
  if (filter->BoundaryMode != EXACT) o.feature_angle = filter->FeatureAngle;
  if (fuse || filter->MinimumQuality != kUsualQuality) o.min_quality = filter->MinimumQuality;
  o.conserve = filter->Conserve;
  if (filter->ScalarTolerance != 0) o.scalar_tolerance = {filter->ScalarTolerance};
  if (filter->StretchFactor != 0) o.stretch_factor = {filter->StretchFactor};
  if (filter->AspectRatio != 0) o.aspect_ratio = filter->AspectRatio;
  if (filter->MaximumVolume != 0) o.max_volume = filter->MaximumVolume;
  o.boundary_tets_stay = filter->BoundaryTetsStay;
  for (const Steering& s : steering) {
    o.arrays.push_back(
        {s.name, s.association == vtkDataObject::FIELD_ASSOCIATION_CELLS, if_given(s.tolerance)});
  }
  if (!filter->KeepRegions) o.regions.emplace();
  if (filter->KeepRegions && !regions.empty()) o.regions = regions;
  o.roi = roi;
  if (filter->WeightArrayName != nullptr) o.weight = filter->WeightArrayName;
  o.original_ids = filter->OriginalIds;
  o.tetrahedralize = filter->Tetrahedralize;
  o.linearize = filter->Linearize;
  o.drop_patches = filter->DropPatches;
  o.drop_patch = dropped_patches;
  o.threads = filter->NumberOfThreads;
  o.memory = static_cast<std::uint64_t>(std::max<vtkTypeInt64>(filter->MemoryLimit, 0));
  if (filter->ScratchDirectory != nullptr) o.scratch = filter->ScratchDirectory;
  o.chunk_tets = static_cast<std::uint64_t>(std::max<vtkIdType>(filter->ChunkTets, 0));
  return o;
}

vtkTetFusion::vtkTetFusion() : Internal(std::make_unique<Internals>()) {}

vtkTetFusion::~vtkTetFusion() {
  this->SetWeightArrayName(nullptr);
  this->SetScratchDirectory(nullptr);
}

void vtkTetFusion::AddSteeringArray(int association, const char* name, double tolerance) {
  if (association != vtkDataObject::FIELD_ASSOCIATION_POINTS &&
      association != vtkDataObject::FIELD_ASSOCIATION_CELLS) {
    vtkErrorMacro(
        << "AddSteeringArray: an array of points or of cells steers, not one of association "
        << association);
    return;
  }
  this->Internal->steering.push_back({association, name != nullptr ? name : "", tolerance});
  this->Modified();
}

void vtkTetFusion::RemoveAllSteeringArrays() {
  this->Internal->steering.clear();
  this->Modified();
}

int vtkTetFusion::GetNumberOfSteeringArrays() {
  return static_cast<int>(this->Internal->steering.size());
}

void vtkTetFusion::AddSteeringPointArray(const char* name) {
  this->AddSteeringArray(vtkDataObject::FIELD_ASSOCIATION_POINTS, name);
}

void vtkTetFusion::AddSteeringCellArray(const char* name) {
  this->AddSteeringArray(vtkDataObject::FIELD_ASSOCIATION_CELLS, name);
}

void vtkTetFusion::RemoveAllSteeringPointArrays() {
  this->Internal->remove_steering(vtkDataObject::FIELD_ASSOCIATION_POINTS);
  this->Modified();
}

void vtkTetFusion::RemoveAllSteeringCellArrays() {
  this->Internal->remove_steering(vtkDataObject::FIELD_ASSOCIATION_CELLS);
  this->Modified();
}

void vtkTetFusion::AddRegionArray(const char* name) {
  this->Internal->regions.emplace_back(name != nullptr ? name : "");
  this->Modified();
}

void vtkTetFusion::RemoveAllRegionArrays() {
  this->Internal->regions.clear();
  this->Modified();
}

int vtkTetFusion::GetNumberOfRegionArrays() {
  return static_cast<int>(this->Internal->regions.size());
}

void vtkTetFusion::AddRegionOfInterest(const char* region) {
  this->Internal->roi.emplace_back(region != nullptr ? region : "");
  this->Modified();
}

void vtkTetFusion::RemoveAllRegionsOfInterest() {
  this->Internal->roi.clear();
  this->Modified();
}

int vtkTetFusion::GetNumberOfRegionsOfInterest() {
  return static_cast<int>(this->Internal->roi.size());
}

void vtkTetFusion::AddDroppedPatch(const char* patch) {
  this->Internal->dropped_patches.emplace_back(patch != nullptr ? patch : "");
  this->Modified();
}

void vtkTetFusion::RemoveAllDroppedPatches() {
  this->Internal->dropped_patches.clear();
  this->Modified();
}

int vtkTetFusion::GetNumberOfDroppedPatches() {
  return static_cast<int>(this->Internal->dropped_patches.size());
}

const char* vtkTetFusion::GetStopSentence() { return this->Internal->update.stop_sentence.c_str(); }
const char* vtkTetFusion::GetReport() { return this->Internal->update.report.c_str(); }
const char* vtkTetFusion::GetErrorMessage() { return this->Internal->update.error_message.c_str(); }
const char* vtkTetFusion::GetWarnings() { return this->Internal->update.warnings.c_str(); }
bool vtkTetFusion::GetGoalReached() {
  const Internals::Update& update = this->Internal->update;
  return update.goals > 0 && update.goals_reached == update.goals;
}
const char* vtkTetFusion::GetNotices() { return this->Internal->update.notices.c_str(); }

int vtkTetFusion::FillInputPortInformation(int, vtkInformation* info) {
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkUnstructuredGrid");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  return 1;
}

int vtkTetFusion::FillOutputPortInformation(int, vtkInformation* info) {
  info->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkDataObject");
  return 1;
}

vtkTypeBool vtkTetFusion::ProcessRequest(vtkInformation* request,
                                         vtkInformationVector** inputVector,
                                         vtkInformationVector* outputVector) {
  if (request->Has(vtkDemandDrivenPipeline::REQUEST_DATA_OBJECT()) == 0) {
    return this->Superclass::ProcessRequest(request, inputVector, outputVector);
  }
  return this->RequestDataObject(request, inputVector, outputVector);
}

// Blocks in the place of the input's blocks, else a grid.
int vtkTetFusion::RequestDataObject(vtkInformation*, vtkInformationVector** inputVector,
                                    vtkInformationVector* outputVector) {
  vtkDataObject* const input = vtkDataObject::GetData(inputVector[0]);
  auto* const blocks = vtkDataObjectTree::SafeDownCast(input);
  if (input != nullptr && blocks == nullptr && !input->IsA("vtkUnstructuredGrid")) {
    this->Internal->update = {};
    this->SetErrorCode(vtkErrorCode::NoError);
    this->Fail(
        static_cast<int>(tetfusion::Code::kBadInput),
        std::string("the input is a ") + input->GetClassName() + ", and not a vtkUnstructuredGrid");
    if (vtkDataObject* const old = vtkDataObject::GetData(outputVector)) old->Initialize();
    return 0;
  }
  const int type = blocks != nullptr ? blocks->GetDataObjectType() : VTK_UNSTRUCTURED_GRID;
  vtkInformation* const info = outputVector->GetInformationObject(0);
  vtkDataObject* const output = vtkDataObject::GetData(info);
  if (output != nullptr && output->GetDataObjectType() == type) return 1;
  auto made = blocks != nullptr
                  ? vtkSmartPointer<vtkDataObject>::Take(blocks->NewInstance())
                  : vtkSmartPointer<vtkDataObject>(vtkSmartPointer<vtkUnstructuredGrid>::New());
  info->Set(vtkDataObject::DATA_OBJECT(), made);
  return 1;
}

// What one block has failed with must outlast the next one.
void vtkTetFusion::Fail(int code, const std::string& message) {
  Internals::Update& update = this->Internal->update;
  if (this->GetErrorCode() == vtkErrorCode::NoError) {
    this->SetErrorCode(vtkErrorCode::UserError + static_cast<unsigned long>(code));
  }
  if (message.empty()) return;  // an abort, which somebody has asked for
  if (!update.has_failed) update.error_message = update.block + message;
  update.has_failed = true;
  vtkErrorMacro(<< update.block << message);
}

void vtkTetFusion::Warn(const std::string& message) {
  Internals::Update& update = this->Internal->update;
  update.warnings += update.block + message + "\n";
  vtkWarningMacro(<< update.block << message);
}

int vtkTetFusion::RequestData(vtkInformation*, vtkInformationVector** inputVector,
                              vtkInformationVector* outputVector) {
  vtkDataObject* const input = vtkDataObject::GetData(inputVector[0]);
  this->Internal->update = {};
  this->SetErrorCode(vtkErrorCode::NoError);
  if (tetfusion::vtk_version::is_aborted(this)) {  // what is before it has ended so, perhaps
    this->Fail(static_cast<int>(tetfusion::Code::kInterrupted), {});
  } else if (auto* const blocks = vtkDataObjectTree::SafeDownCast(input)) {
    this->SimplifyBlocks(blocks, vtkDataObjectTree::GetData(outputVector));
  } else {
    this->SimplifyGrid(input, vtkUnstructuredGrid::GetData(outputVector));
  }
  return this->Internal->update.has_failed ? 0 : 1;
}

// The executive could do it, but forgets from one block to the next that an abort was asked for,
// and does not say which block it is.
void vtkTetFusion::SimplifyBlocks(vtkDataObjectTree* input, vtkDataObjectTree* output) {
  Internals::Update& update = this->Internal->update;
  output->CopyStructure(input);
  const auto blocks = vtk::TakeSmartPointer(input->NewIterator());
  const double shift = this->GetProgressShift(), scale = this->GetProgressScale();
  const auto put_back = [&](vtkTetFusion* self) { self->SetProgressShiftScale(shift, scale); };
  const std::unique_ptr<vtkTetFusion, decltype(put_back)> progress(this, put_back);
  int count = 0, done = 0;
  for (blocks->InitTraversal(); blocks->IsDoneWithTraversal() == 0; blocks->GoToNextItem()) ++count;
  for (blocks->InitTraversal(); blocks->IsDoneWithTraversal() == 0; blocks->GoToNextItem()) {
    this->SetProgressShiftScale(shift + scale * done++ / count, scale / count);
    update.block = words_for_block(blocks);
    vtkNew<vtkUnstructuredGrid> result;
    this->SimplifyBlock(blocks->GetCurrentDataObject(), result);
    output->SetDataSet(blocks, result);
    if (!tetfusion::vtk_version::is_aborted(this)) this->UpdateProgress(1);
  }
  update.block.clear();
  if (update.blocks_without_volume > 0 && update.empty_blocks + update.other_blocks == 0 &&
      this->GetErrorCode() == vtkErrorCode::NoError) {
    this->Fail(static_cast<int>(tetfusion::Code::kBadInput),
               "no block of the input has tetrahedra");
  }
}

void vtkTetFusion::SimplifyBlock(vtkDataObject* block, vtkUnstructuredGrid* output) {
  Internals::Update& update = this->Internal->update;
  // Patches and side sets come as blocks beside the volume.
  if (auto* const surface = vtkDataSet::SafeDownCast(block);
      surface != nullptr && !has_volume(surface)) {
    ++(surface->GetNumberOfCells() > 0 ? update.blocks_without_volume : update.empty_blocks);
    if (tetfusion::vtk_version::is_aborted(this)) {
      this->Fail(static_cast<int>(tetfusion::Code::kInterrupted), "");
    } else if (this->DropPatches) {
      fill_empty_grid(surface, this->OriginalIds, output);
    } else {
      fill_grid_as_it_is(surface, this->OriginalIds, output);
    }
    return;
  }
  if (++update.other_blocks == 2 && this->BoundaryMode != EXACT) {
    this->Warn(
        "each block is simplified for itself: where blocks touch, a boundary that moves "
        "moves apart (BoundaryMode EXACT keeps it)");
  }
  this->SimplifyGrid(block, output);
}

void vtkTetFusion::SimplifyGrid(vtkDataObject* object, vtkUnstructuredGrid* output) {
  Internals& own = *this->Internal;
  own.update.stop_sentence = own.update.report = "";
  const auto fail = [&](tetfusion::Code code, const std::string& message) {
    this->Fail(static_cast<int>(code), message);
  };
  auto* const input = vtkUnstructuredGrid::SafeDownCast(object);
  if (input == nullptr) {
    fail(tetfusion::Code::kBadInput,
         std::string("it is a ") + object->GetClassName() + ", and not a vtkUnstructuredGrid");
    return;
  }
  if (!has_own_cells(input)) {
    fill_empty_grid(input, this->OriginalIds, output);
    return;
  }
  if (tetfusion::vtk_version::is_aborted(this)) {
    fail(tetfusion::Code::kInterrupted, "");
    return;
  }
  const GridView view(input);
  for (const std::string& what : view.left_out()) {
    this->Warn(what + " holds no numbers and is left out");
  }
  tetfusion::Options options = own.options(this);
  if (this->MemoryLimit < 0) {
    fail(tetfusion::Code::kUsage, "memory must be at least 0");
    return;
  }
  const std::string missing = own.add_inputs_to_process(this, input, view, &options);
  if (!missing.empty()) {
    fail(tetfusion::Code::kUsage, missing);
    return;
  }
  Heartbeat heartbeat(this);
  tetfusion::Observer observer;
  observer.progress = [&](double share, std::string_view phase) { heartbeat.report(share, phase); };
  observer.cancelled = [&] { return heartbeat.wants_abort(); };
  observer.notice = [&](std::string_view sentence) {
    own.update.notices += own.update.block + std::string(sentence) + "\n";
  };
  tetfusion::Result result = tetfusion::simplify(view.mesh(), options, observer);
  own.update.stop_sentence = result.report.stop_sentence;
  own.update.report = result.report.json;
  if (result.mesh.tets > 0) fill_grid(view, input, std::move(result.mesh), output);
  if (this->Tetrahedralize && has_cells_to_split(input, this->DropPatches)) {
    unmark_global_ids(output->GetCellData());
  }
  const bool has_goal = options.reduction || options.tets;
  own.update.goals += has_goal ? 1 : 0;
  own.update.goals_reached += result.report.goal_reached ? 1 : 0;
  if (!result.status.ok()) {
    const bool is_abort = result.status.code == tetfusion::Code::kInterrupted &&
                          tetfusion::vtk_version::is_aborted(this);
    fail(result.status.code, is_abort ? "" : result.status.message);
  } else if (has_goal && !result.report.goal_reached) {
    this->Warn(result.report.stop_sentence);
  }
}

void vtkTetFusion::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "TargetReduction: " << this->TargetReduction << "\n";
  os << indent << "NumberOfTetsOutput: " << this->NumberOfTetsOutput << "\n";
  os << indent << "MaximumError: " << this->MaximumError << "\n";
  os << indent << "MaximumRMS: " << this->MaximumRMS << "\n";
  os << indent << "Strict: " << this->Strict << "\n";
  os << indent << "Method: " << name_of_method(this->Method) << "\n";
  os << indent << "BoundaryMode: " << name_of_mode(this->BoundaryMode) << "\n";
  os << indent << "BoundaryTolerance: " << this->BoundaryTolerance << "\n";
  os << indent << "FeatureAngle: " << this->FeatureAngle << "\n";
  os << indent << "MinimumQuality: " << this->MinimumQuality << "\n";
  os << indent << "Conserve: " << this->Conserve << "\n";
  os << indent << "ScalarTolerance: " << this->ScalarTolerance << "\n";
  os << indent << "StretchFactor: " << this->StretchFactor << "\n";
  os << indent << "AspectRatio: " << this->AspectRatio << "\n";
  os << indent << "MaximumVolume: " << this->MaximumVolume << "\n";
  os << indent << "BoundaryTetsStay: " << this->BoundaryTetsStay << "\n";
  os << indent << "SteeringArrays:";
  for (const auto& s : this->Internal->steering) os << " " << s.name;
  os << "\n" << indent << "KeepRegions: " << this->KeepRegions << "\n";
  os << indent << "RegionArrays:";
  for (const std::string& name : this->Internal->regions) os << " " << name;
  os << "\n" << indent << "RegionsOfInterest:";
  for (const std::string& region : this->Internal->roi) os << " " << region;
  os << "\n" << indent << "OriginalIds: " << this->OriginalIds << "\n";
  os << indent << "Tetrahedralize: " << this->Tetrahedralize << "\n";
  os << indent << "Linearize: " << this->Linearize << "\n";
  os << indent << "DropPatches: " << this->DropPatches << "\n";
  os << indent << "DroppedPatches:";
  for (const std::string& patch : this->Internal->dropped_patches) os << " " << patch;
  os << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent
     << "WeightArrayName: " << (this->WeightArrayName != nullptr ? this->WeightArrayName : "(none)")
     << "\n";
  os << indent << "ScratchDirectory: "
     << (this->ScratchDirectory != nullptr ? this->ScratchDirectory : "(none)") << "\n";
  os << indent << "ChunkTets: " << this->ChunkTets << "\n";
  os << indent << "StopSentence: " << this->Internal->update.stop_sentence << "\n";
}
