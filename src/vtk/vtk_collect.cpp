#include "vtk/vtk_collect.h"

#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkPartitionedDataSetCollection.h>

#include "base/error.h"

namespace tetfusion {
namespace {

bool holds_blocks(vtkDataObject* data) {
  return vtkMultiBlockDataSet::SafeDownCast(data) != nullptr ||
         vtkPartitionedDataSetCollection::SafeDownCast(data) != nullptr;
}

std::string name_of_current(vtkCompositeDataIterator* at) {
  if (at->HasCurrentMetaData() == 0) return "";
  const char* const name = at->GetCurrentMetaData()->Get(vtkCompositeDataSet::NAME());
  return name != nullptr ? name : "";
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

vtkSmartPointer<vtkFieldData> field_data_of(vtkAbstractArray* array) {
  auto data = vtkSmartPointer<vtkFieldData>::New();
  data->AddArray(array);
  return data;
}

}  // namespace tetfusion
