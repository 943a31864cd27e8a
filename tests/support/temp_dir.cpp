#include "support/temp_dir.h"

#include <stdlib.h>
#include <unistd.h>

#include <stdexcept>

namespace tetfusion::testing {

TempDir::TempDir() : TempDir(std::filesystem::temp_directory_path()) {}

TempDir TempDir::in_memory() {
  const std::filesystem::path memory = "/dev/shm";
  return TempDir(::access(memory.c_str(), W_OK) == 0 ? memory
                                                     : std::filesystem::temp_directory_path());
}

TempDir::TempDir(const std::filesystem::path& parent) {
  std::string name = (parent / "tetfusion-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
  path_ = name;
}

TempDir::~TempDir() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace tetfusion::testing
