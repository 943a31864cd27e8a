#include "vtk/vtk_reader.h"

#include <vtkInformation.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <utility>

#include "base/error.h"

namespace tetfusion {
namespace {

class FileWithoutSteps : public FileReader {
 public:
  explicit FileWithoutSteps(std::function<void(LoadedFile*)> load) : load_(std::move(load)) {}
  void load(std::size_t, LoadedFile* out) override { load_(out); }

 private:
  std::function<void(LoadedFile*)> load_;
};

}  // namespace

std::unique_ptr<FileReader> without_steps(std::function<void(LoadedFile*)> load) {
  return std::make_unique<FileWithoutSteps>(std::move(load));
}

void refuse_without(const std::string& path, const std::string& module, const std::string& format) {
  throw Error(ErrorCode::kBadInput,
              path + ": this build's VTK has no reader for " + format + " (" + module + ")");
}

std::vector<double> time_steps_in(vtkAlgorithm* reader) {
  vtkInformation* const info = reader->GetOutputInformation(0);
  auto* const key = vtkStreamingDemandDrivenPipeline::TIME_STEPS();
  if (info->Has(key) == 0) return {};
  const double* const times = info->Get(key);
  return {times, times + info->Length(key)};
}

void update_to_step(vtkAlgorithm* reader, const std::vector<double>& times, std::size_t step) {
  if (times.empty()) {
    reader->Update();
  } else {
    reader->UpdateTimeStep(times.at(step));
  }
}

}  // namespace tetfusion
