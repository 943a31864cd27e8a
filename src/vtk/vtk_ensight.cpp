// EnSight 6 and Gold: a case that names the files of its geometry and variables.

#include "vtk/vtk_reader.h"

#ifdef TETFUSION_HAS_ENSIGHT
#include <vtkCellData.h>
#include <vtkDataSet.h>
#include <vtkGenericEnSightReader.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "io/files/mapped_file.h"
#include "vtk/ensight_case.h"
#endif

#include "base/error.h"
#include "vtk/vtk_collect.h"

namespace tetfusion {

#ifdef TETFUSION_HAS_ENSIGHT
namespace {

class EnSightReader : public FileReader {
 public:
  EnSightReader(const std::string& path, const TrapScope& trap)
      : path_(path), trap_(trap), case_(path) {
    const std::string fault = case_.fault_of_times();
    if (!fault.empty()) throw Error(ErrorCode::kBadInput, path + ": " + fault);
    // VTK looks into it to tell text from numbers.
    check_there(geometry_at(case_.times().empty() ? 0 : case_.times().front()));
    reader_->SetCaseFileName(path.c_str());
    reader_->UpdateInformation();
    trap.check(path);
    rounded_ = time_steps_in(reader_);
  }

  // VTK's are rounded to single precision.
  std::vector<double> time_steps() override {
    std::vector<double> times = rounded_;
    for (double& time : times) {
      for (const double written : case_.times()) {
        if (static_cast<float>(written) == static_cast<float>(time)) time = written;
      }
    }
    return times;
  }

  void load(std::size_t step, LoadedFile* out) override {
    const double time = rounded_.empty() ? 0 : rounded_[step];
    out->files = case_.files_at(time);
    for (const std::string& file : out->files) {
      check_there(file);
      check_end(file);
    }
    for (const std::string& fault :
         {case_.fault_of_marks(time), case_.fault_of_counts(time), case_.fault_of_lines(time)}) {
      if (!fault.empty()) throw Error(ErrorCode::kBadInput, path_ + ": " + fault);
    }
    update_to_step(reader_, rounded_, step);
    trap_.check(path_);
    collect(reader_->GetOutput(), path_, out);
    mark_blocks(out);
    tell_of_variables(out);
  }

 private:
  std::string geometry_at(double time) const {
    const std::vector<std::string> files = case_.files_at(time);
    if (!files.empty()) return files.front();
    throw Error(ErrorCode::kBadInput,
                path_ + ": the case names no file of a geometry (GEOMETRY, model:)");
  }

  // Some have no values at a time, and constants are not read.
  void tell_of_variables(LoadedFile* out) const {
    for (const std::string& name : case_.variables()) {
      const bool is_read = std::any_of(
          out->pieces.begin(), out->pieces.end(), [&](const vtkSmartPointer<vtkDataSet>& piece) {
            return piece->GetPointData()->HasArray(name.c_str()) != 0 ||
                   piece->GetCellData()->HasArray(name.c_str()) != 0;
          });
      if (!is_read) out->left_out.push_back("variable '" + name + "'");
    }
  }

  // VTK would go on without some of them.
  void check_there(const std::string& file) const {
    std::error_code unknown;
    if (std::filesystem::exists(file, unknown)) return;
    throw Error(ErrorCode::kBadInput,
                path_ + ": the file " + file + ", which this case names, is not there");
  }

  // VTK takes zeros for what is not there any more. Whole files may lack the end of their last
  // line, but it is one of numbers of 8, 10 or 12 letters then.
  void check_end(const std::string& file) const {
    const MappedFile mapped = MappedFile::open(file);
    const std::string_view text(reinterpret_cast<const char*>(mapped.bytes().data()),
                                mapped.size());
    const std::size_t width = text.size() - (text.rfind('\n') + 1);
    if (!is_ensight_text(text) || width % 8 == 0 || width % 10 == 0 || width % 12 == 0) return;
    throw Error(ErrorCode::kBadInput,
                path_ + ": the file " + file +
                    ", which this case names, ends in the middle of a line: it is cut off");
  }

  const std::string& path_;
  const TrapScope& trap_;
  EnSightCase case_;
  std::vector<double> rounded_;
  vtkNew<vtkGenericEnSightReader> reader_;
};

}  // namespace

std::unique_ptr<FileReader> open_ensight(const std::string& path, const TrapScope& trap) {
  return std::make_unique<EnSightReader>(path, trap);
}
#else
std::unique_ptr<FileReader> open_ensight(const std::string& path, const TrapScope&) {
  refuse_without(path, "IOEnSight", "EnSight");
}
#endif

}  // namespace tetfusion
