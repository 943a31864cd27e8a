// CGNS: bases of zones, each with its patches.

#include "vtk/vtk_reader.h"

#ifdef TETFUSION_HAS_CGNS
#include <vtkCGNSReader.h>
#include <vtkCompositeDataSet.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#endif

#include "base/error.h"
#include "vtk/vtk_collect.h"

namespace tetfusion {

#ifdef TETFUSION_HAS_CGNS
namespace {

std::string name_of_block(vtkMultiBlockDataSet* blocks, unsigned index) {
  if (blocks->HasMetaData(index) == 0) return "";
  const char* const name = blocks->GetMetaData(index)->Get(vtkCompositeDataSet::NAME());
  return name != nullptr ? name : "";
}

class CgnsReader : public FileReader {
 public:
  CgnsReader(const std::string& path, const TrapScope& trap) : path_(path), trap_(trap) {
    const StandardErrorCaught caught;
    reader_->SetFileName(path.c_str());
    reader_->UpdateInformation();
    trap.check(path);
    check(caught);
  }

  // VTK says 0 of a file that tells no times.
  std::vector<double> time_steps() override {
    std::vector<double> times = time_steps_in(reader_);
    if (times == std::vector<double>{0}) times.clear();
    return times;
  }

  void load(std::size_t step, LoadedFile* out) override {
    reader_->EnableAllBases();
    reader_->EnableAllFamilies();
    reader_->SetFamilyArrayStatus("Wall", 1);  // VTK's name for walls that are of no family
    reader_->EnableAllPointArrays();
    reader_->EnableAllCellArrays();
    reader_->SetDoublePrecisionMesh(1);
    reader_->SetLoadBndPatch(true);
    const StandardErrorCaught caught;
    update_to_step(reader_, time_steps(), step);
    trap_.check(path_);
    check(caught);
    out->format = "CGNS file";
    auto* const bases = vtkMultiBlockDataSet::SafeDownCast(reader_->GetOutputDataObject(0));
    for (unsigned b = 0; bases != nullptr && b < bases->GetNumberOfBlocks(); ++b) {
      auto* const base = vtkMultiBlockDataSet::SafeDownCast(bases->GetBlock(b));
      const bool is_only = bases->GetNumberOfBlocks() == 1;
      if (base != nullptr) add_zones(base, is_only ? "" : name_of_block(bases, b) + "/", out);
    }
    // VTK's own mark of patches, which the blocks tell better.
    for (const auto& field : out->field_data) {
      if (field != nullptr) field->RemoveArray("ispatch");
    }
    mark_blocks(out);
    for (const std::string& warning : trap_.warnings()) {
      out->left_out.push_back("what VTK warns of: '" + warning + "'");
    }
  }

 private:
  // VTK goes on with what the library complains of.
  void check(const StandardErrorCaught& caught) const {
    const std::string words = caught.text();
    if (words.empty()) return;
    throw Error(ErrorCode::kBadInput, path_ + ": the CGNS library cannot read it: " + words);
  }

  // A zone that has patches is a block of two: "Internal", and a block of all patches.
  void add_zones(vtkMultiBlockDataSet* base, const std::string& prefix, LoadedFile* out) const {
    for (unsigned z = 0; z < base->GetNumberOfBlocks(); ++z) {
      const std::string name = prefix + name_of_block(base, z);
      auto* const parts = vtkMultiBlockDataSet::SafeDownCast(base->GetBlock(z));
      if (parts == nullptr) {
        add_block(base->GetBlock(z), name, path_, out);
        continue;
      }
      for (unsigned p = 0; p < parts->GetNumberOfBlocks(); ++p) {
        auto* const patches = vtkMultiBlockDataSet::SafeDownCast(parts->GetBlock(p));
        if (patches == nullptr) add_block(parts->GetBlock(p), name, path_, out);
        for (unsigned k = 0; patches != nullptr && k < patches->GetNumberOfBlocks(); ++k) {
          add_block(patches->GetBlock(k), name + "/" + name_of_block(patches, k), path_, out);
        }
      }
    }
  }

  const std::string& path_;
  const TrapScope& trap_;
  vtkNew<vtkCGNSReader> reader_;
};

}  // namespace

bool is_cgns(const std::string& path) {
  const TrapScope complaints;  // what is no CGNS file is an error to VTK
  const StandardErrorCaught caught;
  vtkNew<vtkCGNSReader> reader;
  return reader->CanReadFile(path.c_str()) != 0;
}

std::unique_ptr<FileReader> open_cgns(const std::string& path, const TrapScope& trap) {
  if (!is_cgns(path)) {
    throw Error(ErrorCode::kBadInput,
                path +
                    ": is not a CGNS file, or is damaged, or of a newer version than this "
                    "build's VTK reads");
  }
  return std::make_unique<CgnsReader>(path, trap);
}
#else
bool is_cgns(const std::string&) { return false; }

std::unique_ptr<FileReader> open_cgns(const std::string& path, const TrapScope&) {
  refuse_without(path, "IOCGNSReader", "CGNS");
}
#endif

}  // namespace tetfusion
