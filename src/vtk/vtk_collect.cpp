#include "vtk/vtk_collect.h"

#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkStringArray.h>

#include <algorithm>
#include <set>

#include "base/error.h"

namespace tetfusion {
namespace {

bool holds_blocks(vtkDataObject* data) {
  return vtkMultiBlockDataSet::SafeDownCast(data) != nullptr ||
         vtkPartitionedDataSetCollection::SafeDownCast(data) != nullptr;
}

std::string name_of_current(vtkCompositeDataIterator* at) {
  if (at->HasCurrentMetaData() == 0) return "";
  const char* const told = at->GetCurrentMetaData()->Get(vtkCompositeDataSet::NAME());
  std::string name = told != nullptr ? told : "";
  name.erase(name.find_last_not_of(' ') + 1);  // EnSight pads it
  return name;
}

}  // namespace

void collect(vtkDataObject* data, const std::string& path, LoadedFile* out) {
  if (data == nullptr) throw Error(ErrorCode::kBadInput, path + ": VTK read nothing from it");
  if (auto* composite = vtkCompositeDataSet::SafeDownCast(data)) {
    out->field_data.emplace_back(composite->GetFieldData());
    auto at = vtk::TakeSmartPointer(composite->NewIterator());
    at->SkipEmptyNodesOff();  // an empty block is counted
    if (auto* children = vtkDataObjectTreeIterator::SafeDownCast(at)) {
      children->TraverseSubTreeOff();
      children->VisitOnlyLeavesOff();
    }
    for (at->InitTraversal(); !at->IsDoneWithTraversal(); at->GoToNextItem()) {
      vtkDataObject* child = at->GetCurrentDataObject();
      const bool is_block = holds_blocks(data) && !holds_blocks(child);
      if (is_block) out->block_names.push_back(name_of_current(at));
      if (child != nullptr) collect(child, path, out);
      if (is_block) ++out->blocks;
    }
    return;
  }
  auto* set = vtkDataSet::SafeDownCast(data);
  if (set == nullptr) {
    throw Error(ErrorCode::kBadInput,
                path + ": holds a " + data->GetClassName() + ", which has no tetrahedra");
  }
  out->field_data.emplace_back(set->GetFieldData());
  out->pieces.emplace_back(set);
  out->block_of.push_back(out->blocks);
}

void add_block(vtkDataObject* data, const std::string& name, const std::string& path,
               LoadedFile* out) {
  if (data == nullptr) return;
  out->block_names.push_back(name);
  collect(data, path, out);
  ++out->blocks;
}

void collect_pieces(vtkAlgorithm* reader, int pieces, const std::string& path,
                    const TrapScope& trap, LoadedFile* out) {
  for (int i = 0; i < pieces; ++i) {
    reader->UpdatePiece(i, pieces, 0);
    trap.check(path);
    vtkDataObject* const read = reader->GetOutputDataObject(0);
    const auto copy = vtk::TakeSmartPointer(read->NewInstance());
    copy->ShallowCopy(read);
    collect(copy, path, out);
  }
}

void mark_blocks(LoadedFile* file) {
  constexpr char kName[] = "block";
  std::set<int> with_cells;
  for (std::size_t k = 0; k < file->pieces.size(); ++k) {
    if (file->pieces[k]->GetCellData()->HasArray(kName) != 0) return;
    if (file->pieces[k]->GetNumberOfCells() > 0) with_cells.insert(file->block_of[k]);
  }
  if (with_cells.size() < 2) return;
  for (std::size_t k = 0; k < file->pieces.size(); ++k) {
    vtkNew<vtkIntArray> blocks;
    blocks->SetName(kName);
    blocks->SetNumberOfTuples(file->pieces[k]->GetNumberOfCells());
    blocks->FillValue(file->block_of[k]);
    file->pieces[k]->GetCellData()->AddArray(blocks);
  }
  const auto is_named = [](const std::string& name) { return !name.empty(); };
  if (std::none_of(file->block_names.begin(), file->block_names.end(), is_named)) return;
  vtkNew<vtkStringArray> names;
  names->SetName("block_names");
  for (const std::string& name : file->block_names) names->InsertNextValue(name);
  file->field_data.push_back(field_data_of(names));
}

vtkSmartPointer<vtkFieldData> field_data_of(vtkAbstractArray* array) {
  auto data = vtkSmartPointer<vtkFieldData>::New();
  data->AddArray(array);
  return data;
}

}  // namespace tetfusion
